# A car body of sheets as a deck: floor, roof, sides, front and rear, with openings for windows and doors. Nodes are numbered by their
# place in a grid of NX x NY x NZ boxes of 0.1 m; groups of the floor are where the mounts and the seat are.
function node(i, j, k) { return 1 + i + (NX + 1) * (j + (NY + 1) * k) }
function sheet(set, a, b, c, d) {
  elements[set] = elements[set] sprintf("%d, %d, %d, %d, %d\n", ++count, a, b, c, d)
  used[a] = used[b] = used[c] = used[d] = 1
}
function group(name, x, y,   i, j) {
  printf "*NSET, NSET=%s\n", name
  for (i = 0; i <= NX; i++) for (j = 0; j <= NY; j++)
    if ((i * H - x) ^ 2 + (j * H - W / 2 - y) ^ 2 < 0.0226) printf "%d\n", node(i, j, 0)
}
BEGIN {
  NX = 40; NY = 16; NZ = 12; H = 0.1; W = NY * H
  for (i = 0; i < NX; i++) for (j = 0; j < NY; j++) {
    sheet("FLOOR", node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0))
    sheet("SHELL", node(i, j, NZ), node(i + 1, j, NZ), node(i + 1, j + 1, NZ), node(i, j + 1, NZ))
  }
  for (i = 0; i < NX; i++) for (k = 0; k < NZ; k++) {
    door = (i >= 6 && i < 18 || i >= 20 && i < 32) && k >= 1 && k < NZ - 1
    if (door) continue
    sheet("SHELL", node(i, 0, k), node(i + 1, 0, k), node(i + 1, 0, k + 1), node(i, 0, k + 1))
    sheet("SHELL", node(i, NY, k), node(i + 1, NY, k), node(i + 1, NY, k + 1), node(i, NY, k + 1))
  }
  for (j = 0; j < NY; j++) for (k = 0; k < NZ; k++) {
    window = k >= NZ / 2 && k < NZ - 1 && j >= 1 && j < NY - 1
    if (window) continue
    sheet("SHELL", node(0, j, k), node(0, j + 1, k), node(0, j + 1, k + 1), node(0, j, k + 1))
    sheet("SHELL", node(NX, j, k), node(NX, j + 1, k), node(NX, j + 1, k + 1), node(NX, j, k + 1))
  }
  print "*HEADING\ncar body, drawn by draw.awk\n*NODE"
  for (k = 0; k <= NZ; k++) for (j = 0; j <= NY; j++) for (i = 0; i <= NX; i++)
    if (node(i, j, k) in used) printf "%d, %g, %g, %g\n", node(i, j, k), i * H, j * H - W / 2, k * H
  for (set in elements) printf "*ELEMENT, TYPE=S4, ELSET=%s\n%s", set, elements[set]
  group("FL", 0.6, 0.6); group("FR", 0.6, -0.6); group("RL", 3.2, 0.6); group("RR", 3.2, -0.6); group("SEAT", 1.5, 0.4)
  # Beads: mass and stretch of sheets of 3 mm (floor 6 mm), 25 times their bending stiffness.
  print "*MATERIAL, NAME=BEADED\n*ELASTIC\n42e9, 0.3\n*DENSITY\n1570"
  print "*SHELL SECTION, ELSET=FLOOR, MATERIAL=BEADED\n0.03\n*SHELL SECTION, ELSET=SHELL, MATERIAL=BEADED\n0.015"
}
