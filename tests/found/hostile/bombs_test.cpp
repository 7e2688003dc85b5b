// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Small files that stand for much: subsystems of ten in ten (subsystem_bomb/), studies of 1e11 choices (study/), matrices that
// unpack without end.  Each is refused within seconds, by the number that it exceeds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <zlib.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>

#include "mbs/base/hdf5/file.hpp"
#include "tests/app/command.hpp"

namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using ::testing::HasSubstr;

std::string sample(const std::string& name) {
  return std::string(FLEXURA_SOURCE_DIR) + "/tests/found/hostile/" + name;
}

/// The program may take 2 GB of addresses beside what its libraries map, and a tenth of what it would take to go through all
/// (hours): 20 s.
void expect_refused(const std::vector<std::string>& words, const std::string& why) {
  const auto start = std::chrono::steady_clock::now();
  const Outcome outcome = test::run("flexura", words);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(why));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Bombs, OfSubsystemsAreCounted) {
  expect_refused({"check", sample("subsystem_bomb/t0.toml")},
                 "is placed as subsystem number 1001 of the mechanism");
  // What a thousand may still hold.
  const Folder folder;
  std::string many;
  for (int k = 0; k < 20; ++k) many += "[subsystem.s" + std::to_string(k) + "]\nfile = \"long.toml\"\n";
  folder.write("long.toml", "name = \"long\"\n" + std::string(1'000'000, '#') + "\n");
  const fs::path whole = folder.write("many.toml", many);
  expect_refused({"check", whole.string()}, "makes 10 MB of text of all subsystems; at most 10 MB are taken");
}

TEST(Bombs, OfChoicesAreCounted) {
  expect_refused({"study", sample("study/many.toml")},
                 "2.82e+11 choices of 12 axes; at most 10000 are taken");
  const Folder folder;
  fs::copy(sample("study/rr.toml"), folder / "rr.toml");
  std::string named = "mechanism = \"rr.toml\"\n";
  for (int k = 0; k < 10001; ++k)
    named += "[choice.c" + std::to_string(k) + "]\nset = [\"parameters.x0=1\"]\n";
  const fs::path study = folder.write("s.toml", named + "[quantity.a]\nof = \"hinge.angle\"\n");
  expect_refused({"study", study.string()}, "1e+04 choices of 0 axes; at most 10000 are taken");
}

/// A part of this deck.
void expect_deck_refused(const std::string& name, const std::string& deck, const std::string& why) {
  const Folder folder;
  folder.write(name, deck);
  const fs::path part =
      folder.write("part.toml", "[geometry]\nfile = \"" + name +
                                    "\"\n[material.m]\nyoung = 1\npoisson = 0\ndensity = 1\n"
                                    "[interface.a]\nby = \"nodes\"\nnodes = [1]\n");
  expect_refused({"reduce", part.string()}, why);
}

TEST(Bombs, OfDecksAreCounted) {
  const std::string why = "stand for more than 20000000 nodes and elements in all";
  expect_deck_refused("a.inp", "*NODE\n1,0,0,0\n*NSET, NSET=A, GENERATE\n1,100000000,1\n",
                      "line 4: generated sets");
  std::string sets = "*NODE\n1,0,0,0\n*NSET, NSET=A, GENERATE\n1,1000000,1\n*NSET, NSET=B\n";
  for (int k = 0; k < 30; ++k) sets += "A,A,A,A,A,A,A,A\n";
  expect_deck_refused("b.inp", sets, why);
  std::string instances =
      "*PART, NAME=P\n*NODE\n1,0,0,0\n*NSET, NSET=A, GENERATE\n1,1000000,1\n*END PART\n*ASSEMBLY, NAME=M\n";
  for (int k = 0; k < 30; ++k)
    instances += "*INSTANCE, NAME=I" + std::to_string(k) + ", PART=P\n*END INSTANCE\n";
  expect_deck_refused("c.inp", instances + "*END ASSEMBLY\n", why);
  std::string grids = "BEGIN BULK\n";
  for (int k = 1; k <= 10000; ++k) grids += "GRID," + std::to_string(k) + ",,1.,2.,3.\n";
  for (int k = 0; k < 2500; ++k) grids += "SPC1,1,123,1,THRU,10000\n";
  expect_deck_refused("d.bdf", grids + "ENDDATA\n", why);
  // Lines that go on for ever.
  std::string lines = "*NODE\n1,0,0,0\n*NSET, NSET=A,\n", name = "BEGIN BULK\nINCLUDE 'abc\n";
  for (int k = 0; k < 300000; ++k) lines += "B=C,\n", name += "abcdefghijklmnopqrstuvwxyz\n";
  expect_deck_refused("e.inp", lines, "a keyword line of more than 100000 letters");
  expect_deck_refused("f.bdf", name, "the name of an INCLUDE has more than 10000 letters");
}

// Nodes of ten in ten that show nothing, and one picture in many links.
TEST(Bombs, OfPicturesAreCounted) {
  const Folder folder;
  std::string scene = "<?xml version=\"1.0\"?><COLLADA><library_nodes>";
  for (int level = 0; level < 12; ++level) {
    scene += "<node id=\"n" + std::to_string(level) + "\">";
    for (int k = 0; k < 10; ++k) scene += "<instance_node url=\"#n" + std::to_string(level + 1) + "\"/>";
    scene += "</node>";
  }
  folder.write("bomb.dae",
               scene +
                   "<node id=\"n12\"/></library_nodes><library_visual_scenes><visual_scene id=\"v\"><node "
                   "id=\"r\"><instance_node url=\"#n0\"/></node></visual_scene></library_visual_scenes>"
                   "<scene><instance_visual_scene url=\"#v\"/></scene></COLLADA>");
  const fs::path robot = folder.write("r.urdf",
                                      "<robot name=\"r\"><link name=\"a\"><inertial><mass "
                                      "value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" "
                                      "ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh "
                                      "filename=\"bomb.dae\"/></geometry></visual></link></robot>");
  const auto start = std::chrono::steady_clock::now();
  const Outcome outcome = test::run("flexura", {"import", robot.string(), "-o", folder / "r"});
  EXPECT_THAT(outcome.err, HasSubstr("at most 100000 are taken"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

// One picture under thousands of links: it is not read again once the most triangles are reached.  Attributes without end, names of
// states without end: each is compared with those before it.
TEST(Bombs, OfRobotsAndStatesAreCounted) {
  const Folder folder;
  std::string attributes = "<robot name=\"r\"><link";
  for (int k = 0; k < 100000; ++k) attributes += " a" + std::to_string(k) + "=\"1\"";
  const fs::path robot = folder.write("r.urdf", attributes + " name=\"a\"/></robot>");
  expect_refused({"import", robot.string(), "-o", folder / "r"}, "more than 1000 attributes");
  std::string state = "{\"format\": \"flexura state\", \"version\": 1";
  for (int k = 0; k < 500000; ++k) state += ", \"a" + std::to_string(k) + "\": 1";
  const fs::path states = folder.write("s.json", state + "}");
  const fs::path mechanism = folder.write("m.toml",
                                          "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = "
                                          "\"prismatic\"\nfrom = \"ground\"\nto = \"b\"\n");
  expect_refused({"simulate", mechanism.string(), "-o", folder / "o.h5", "--from-state", states.string()},
                 "more than 50000 names");
}

/// A data set of bytes in the file that says more than it stores, in place of what was there.
void put_unstored(const fs::path& file, const char* name, hsize_t n) {
  const hid_t h5 = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), space = H5Screate_simple(1, &n, nullptr),
              how = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk = 1 << 20;
  H5Pset_chunk(how, 1, &chunk);
  H5Pset_deflate(how, 2);
  if (H5Lexists(h5, name, H5P_DEFAULT) > 0) H5Ldelete(h5, name, H5P_DEFAULT);
  const hid_t set = H5Dcreate2(h5, name, H5T_NATIVE_UINT8, space, H5P_DEFAULT, how, H5P_DEFAULT);
  EXPECT_GE(set, 0);
  H5Dclose(set), H5Pclose(how), H5Sclose(space), H5Fclose(h5);
}

/// Many names of one data set of zeros, which are stored.
void put_often(const fs::path& file, int names, hsize_t n) {
  const hid_t h5 = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), space = H5Screate_simple(1, &n, nullptr),
              how = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk = 1 << 17;
  H5Pset_chunk(how, 1, &chunk);
  H5Pset_deflate(how, 9);
  const std::vector<double> zeros(n, 0.0);
  const hid_t set = H5Dcreate2(h5, "zeros_0", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, how, H5P_DEFAULT);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, zeros.data());
  for (int k = 1; k < names; ++k)
    H5Lcreate_hard(h5, "zeros_0", h5, ("zeros_" + std::to_string(k)).c_str(), H5P_DEFAULT, H5P_DEFAULT);
  H5Dclose(set), H5Pclose(how), H5Sclose(space), H5Fclose(h5);
}

TEST(Bombs, OfHdf5AreHeldAgainstTheirFile) {
  const Folder folder;
  const fs::path part = folder.write(
      "part.toml",
      "[material.m]\nyoung = 1e11\npoisson = 0.3\ndensity = 1e3\n[section.s]\ntype = \"circle\"\ndiameter = "
      "0.1\n"
      "[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [1, 0, 0]\n[member.m]\nnodes = [\"a\", \"b\"]\n"
      "[interface.a]\n[interface.b]\n");
  ASSERT_EQ(test::run("flexura", {"reduce", part.string(), "-q"}).exit_code, 0);
  put_unstored(folder / "part.se.h5", "source", 200'000'000);
  expect_refused({"check", folder / "part.se.h5"}, "source: stands for 200 MB, of which the file holds 0 MB");
  // Stored, but under many names.
  const fs::path often = folder / "often.h5";
  H5Fclose(H5Fcreate(often.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  put_often(often, 100, 1 << 20);
  const hdf5::File file(often, hdf5::Mode::read);
  std::vector<double> into(1 << 20);
  const auto read_all = [&] {
    for (int k = 0; k < 100; ++k)
      file.root().read("zeros_" + std::to_string(k), {std::size_t{1} << 20}, into.data());
  };
  EXPECT_THROW(read_all(), hdf5::BadFile);
}

// A link under the name of an output leads to no file of another kind.
// One chunk whose stream goes on for 64 MB where 1.5 kB belong; and one that is packed twice.
TEST(Bombs, OfHdf5ChunksAreHeldAgainstTheirSize) {
  const Folder folder;
  std::vector<unsigned char> zeros(64'000'000), packed(compressBound(zeros.size()));
  uLongf n = packed.size();
  ASSERT_EQ(compress(packed.data(), &n, zeros.data(), zeros.size()), Z_OK);
  for (const int deflates : {1, 2}) {
    const fs::path path = folder / ("chunk" + std::to_string(deflates) + ".h5");
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t size[2] = {14, 14}, first[2] = {0, 0};
    const hid_t space = H5Screate_simple(2, size, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 2, size);
    for (int k = 0; k < deflates; ++k) H5Pset_deflate(properties, 6);
    const hid_t data = H5Dcreate2(file, "K", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    ASSERT_GE(H5Dwrite_chunk(data, H5P_DEFAULT, 0, first, n, packed.data()), 0);
    H5Dclose(data), H5Pclose(properties), H5Sclose(space), H5Fclose(file);
    const hdf5::File opened(path, hdf5::Mode::read);
    try {
      hdf5::read_matrix(opened.root(), "K", 14, 14);
      FAIL() << deflates;
    } catch (const hdf5::BadFile& refused) {
      EXPECT_THAT(refused.what(), HasSubstr("made to fill the memory"));
    }
  }
}

TEST(Bombs, OfBodiesAndMeasuresAreCounted) {
  const Folder folder;
  std::string bodies = "gravity = [0, 0, 0]\n";
  for (int k = 0; k < 1700; ++k)
    bodies += "[body.b" + std::to_string(k) + "]\nmass = 1\ninertia = [1, 1, 1]\n";
  expect_refused({"check", folder.write("bodies.toml", bodies)}, "has 10200 speeds, 10000 are taken");
  std::string measures =
      "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = "
      "\"b\"\n"
      "[force.f]\ntype = \"joint_force\"\njoint = \"j\"\nvalue = \"m60\"\n[measure.m0]\ntype = "
      "\"formula\"\nvalue = \"t\"\n";
  for (int k = 1; k <= 60; ++k) {
    const std::string last = "m" + std::to_string(k - 1);
    measures += "[measure.m" + std::to_string(k) + "]\ntype = \"formula\"\nvalue = \"" + last + "*" + last +
                "+sin(" + last + ")\"\n";
  }
  expect_refused({"check", folder.write("measures.toml", measures)}, "let them read one another less often");
}

// A terabyte that takes no room on the disk, and what the kernel makes up.
TEST(Bombs, OfSparseFilesAreRefused) {
  const Folder folder;
  for (const char* name : {"big.toml", "big.json", "big.stl"}) {
    std::ofstream(folder / name).put('\n');
    fs::resize_file(folder / name, 1ull << 40);
  }
  const std::string why = "made to fill the memory";
  expect_refused({"reduce", folder / "big.toml"}, why);
  expect_refused({"report", folder / "big.json", "-o", folder / "big.html"}, why);
  expect_refused({"reduce", "--list-faces", folder / "big.stl"}, why);
  expect_refused({"check", "/proc/kmsg"}, "is a file of the kernel");
}

TEST(Bombs, OutputsLeaveFilesOfOtherKindsBehindLinks) {
  const Folder folder, mine;
  const fs::path precious = mine.write(".bashrc", "precious");
  const fs::path mechanism =
      folder.write("m.toml",
                   "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = "
                   "\"prismatic\"\nfrom = \"ground\"\nto = \"b\"\n[solver]\nend_time = 0.01\n");
  fs::create_symlink(precious, folder / "m.h5");
  expect_refused({"simulate", mechanism.string(), "-o", folder / "m.h5"}, "a file of another kind");
  EXPECT_EQ(test::read_text(precious), "precious");
}

class PackedMatrices : public ::testing::Test {
 protected:
  /// A part of finished matrices, of which the stiffness is this text, `times` over, packed.
  void expect_matrix_refused(const std::string& head, const std::string& piece, int times,
                             const std::string& why) {
    folder_.write("nodes.csv", "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n");
    folder_.write("M.mtx", "1 1 1\n");
    const gzFile file = gzopen((folder_ / "K.mtx.gz").c_str(), "wb");
    gzwrite(file, head.data(), static_cast<unsigned>(head.size()));
    for (int k = 0; k < times; ++k) gzwrite(file, piece.data(), static_cast<unsigned>(piece.size()));
    gzclose(file);
    const fs::path part =
        folder_.write("part.toml",
                      "[geometry]\nfile = \"nodes.csv\"\n[matrices]\nstiffness = \"K.mtx.gz\"\nmass = "
                      "\"M.mtx\"\n[interface.a]\nby = \"nodes\"\nnodes = [1, 2, 3]\n");
    expect_refused({"reduce", part.string()}, why);
  }
  Folder folder_;
};

TEST_F(PackedMatrices, AreUnpackedAsFarAsTheirSizeCanMean) {
  const std::string lines(1 << 20, '\n');
  expect_matrix_refused("", lines, 200, "unpacks to more than 20 times the file's size");
  std::string ones;
  while (ones.size() < 1 << 20) ones += "1,1,1,1,1.\n";
  expect_matrix_refused("", ones, 100, "unpacks to more than 20 times the file's size");
}

TEST_F(PackedMatrices, HaveLinesOfBoundedLength) {
  expect_matrix_refused("", std::string(1 << 20, ' '), 200, "line 1: is longer than 2000000 letters");
  expect_matrix_refused("", std::string(1 << 20, '\0'), 20, "holds a zero character");
}

}  // namespace
}  // namespace flexura
