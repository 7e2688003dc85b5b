# The four-bar at three speeds, and which frequencies its motor's torque holds.
import flexura
from flexura import plot

largest = {}
for speed in (5, 10, 20):
    results = flexura.simulate(
        "../four_bar/four_bar.toml",
        f"four_bar_{speed}.h5",                       # a results file for each
        settings={"parameters.speed": f"{speed} rad/s", "solver.end_time": f"{4 * 6.28318531 / speed} s"},
    )
    torque = results["run"]["motor.drive_force"]
    largest[speed] = abs(torque).max()
    print(f"{speed} rad/s: {largest[speed]:.3f} {torque.unit}")
print(f"twice the speed takes {largest[20] / largest[10]:.2f} times the torque")

frequency, amplitude = results["run"].spectrum("motor.drive_force")
strongest = amplitude[1:].argmax() + 1                # the first entry is the mean
print(f"strongest at {frequency[strongest]:.2f} {frequency.unit}: {amplitude[strongest]:.3f} {amplitude.unit}")
plot.spectra(results, "motor.drive_force").figure.savefig("torque_spectrum.png")
