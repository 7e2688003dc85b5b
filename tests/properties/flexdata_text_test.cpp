// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every FlexData file: how its XML is written (quotes, blanks, comments, CDATA, order of attributes, case, exponents, bodies beside it)
// does not change what is read, and a body is found by its id.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>

#include "mbs/superelement/exchange/exchange.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::superelement {
namespace {

using mbs::chance::Chance;
using ::testing::HasSubstr;

class FlexDataText : public mbs::test::TestFolder {};

FlexData random_body(Chance& chance, int id) {
  FlexData data;
  data.id = id;
  data.num_nodes = chance.below(5000);
  const int n = 1 + chance.below(3), m = 1 + chance.below(4);
  for (int k = 0; k < n; ++k) data.nodes.push_back({k + 1 + 10 * chance.below(9), chance.vector(3.0)});
  for (int j = 0; j < m; ++j) {
    const double hz = chance.between(1.0, 900.0), omega = 2.0 * std::numbers::pi * hz;
    data.modes.push_back({7 + j, hz, omega * omega, chance.between(0.0, 0.1)});
  }
  data.shapes.resize(6 * n, m);
  for (double& value : data.shapes.reshaped()) value = chance.either_sign(1e-12, 1.0);
  return data;
}

// As somebody might write it; all numbers by 17 digits, so that they are read back to the bit.
std::string as_xml(Chance& chance, const FlexData& data) {
  const auto gap = [&] {
    const char* const gaps[] = {" ", "\n", "\t", "\n  \t", "  \n"};
    return std::string(chance.one_of(gaps));
  };
  const auto comment = [&] {
    const char* const comments[] = {"", "", "<!-- a > b, 1 2 3 -->", "<!-- <ModeData> 5 -->",
                                    "<!--\n<NodeData>\n-->"};
    return std::string(chance.one_of(comments));
  };
  const auto number = [&](double value) {
    std::string text = fmt::format("{:.16e}", value);
    if (chance.flip(0.2)) text[text.find('e')] = chance.flip(0.5) ? 'D' : 'E';
    return (chance.flip(0.1) && value > 0 ? "+" : "") + text;
  };
  const auto tag = [&](std::string name) {
    if (chance.flip(0.3))
      for (char& c : name) c = static_cast<char>(chance.flip(0.5) ? std::tolower(c) : std::toupper(c));
    return name;
  };
  std::vector<std::string> attributes;
  const auto attribute = [&](const char* name, std::size_t value) {
    const char* const quotes[] = {"\"", "'"};
    const std::string quote = chance.one_of(quotes), a = chance.flip(0.5) ? gap() : "",
                      b = chance.flip(0.5) ? gap() : "";
    attributes.push_back(fmt::format("{}{}={}{}{}{}", tag(name), a, b, quote, value, quote));
  };
  attribute("id", static_cast<std::size_t>(data.id));
  if (chance.flip(0.7)) attribute("num_nodes", static_cast<std::size_t>(data.num_nodes));
  attribute("num_sel_modes", data.modes.size());
  attribute("num_sel_nodes", data.nodes.size());
  if (chance.flip(0.3)) attributes.push_back("label='id = \"9\" > x'");
  for (std::size_t k = attributes.size(); k > 1; --k)
    std::swap(attributes[k - 1], attributes[static_cast<std::size_t>(chance.below(static_cast<int>(k)))]);
  std::string text = "<" + tag("Reference_FlexData");
  for (const std::string& a : attributes) text += gap() + a;
  text += (chance.flip(0.3) ? gap() : "") + ">" + comment();
  const bool cdata = chance.flip(0.2);
  std::string modes, nodes;
  for (const auto& mode : data.modes)
    modes += fmt::format("{}{}{}{}{}{}{}{}{}", mode.id, gap(), number(mode.frequency), gap(),
                         number(mode.eigenvalue), gap(), number(mode.damping), gap(), cdata ? "" : comment());
  for (const auto& node : data.nodes)
    nodes += fmt::format("{}{}{}{}{}{}{}{}", node.id, gap(), number(node.position[0]), gap(),
                         number(node.position[1]), chance.flip(0.1) ? ", " : gap(), number(node.position[2]),
                         gap());
  for (const double value : data.shapes.reshaped()) nodes += number(value) + gap();
  const auto block = [&](const char* name, const std::string& inside) {
    return fmt::format("<{}>{}{}{}</{}>{}", tag(name), comment(),
                       cdata ? "<![CDATA[" + inside + "]]>" : inside, comment(), tag(name), gap());
  };
  text += block("ModeData", modes) + comment() + block("NodeData", nodes);
  for (const auto& load : data.loads) {
    std::string numbers;
    for (const double value : load.on_modes) numbers += number(value) + gap();
    text += block("ModeLoad", numbers) + comment();
  }
  return text + "</" + tag("Reference_FlexData") + ">" + gap();
}

TEST_F(FlexDataText, SaysTheSameHoweverItIsWrittenAndWhereverTheBodyStands) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const int n_bodies = 1 + chance.below(3);
    std::vector<FlexData> bodies;
    std::string text = chance.flip(0.5) ? "<?xml version=\"1.0\"?>\n<MotionSolve>\n<Model>\n" : "";
    for (int k = 0; k < n_bodies; ++k) {
      bodies.push_back(random_body(chance, 30101 + 7 * k));
      for (int load = chance.below(3); load > 0; --load) {
        Eigen::VectorXd on_modes(static_cast<Eigen::Index>(bodies.back().modes.size()));
        for (double& value : on_modes) value = chance.either_sign(1e-12, 1.0);
        bodies.back().loads.push_back({.on_modes = on_modes});
      }
      text += as_xml(chance, bodies.back());
    }
    const auto path = file(text, "x.xml");
    for (const FlexData& wanted : bodies) {
      const FlexData read = read_flexdata(path, wanted.id);
      EXPECT_EQ(read.id, wanted.id);
      ASSERT_EQ(read.loads.size(), wanted.loads.size());
      for (std::size_t k = 0; k < read.loads.size(); ++k)
        EXPECT_EQ(read.loads[k].on_modes, wanted.loads[k].on_modes);
      ASSERT_EQ(read.nodes.size(), wanted.nodes.size());
      ASSERT_EQ(read.modes.size(), wanted.modes.size());
      for (std::size_t k = 0; k < read.nodes.size(); ++k) {
        EXPECT_EQ(read.nodes[k].id, wanted.nodes[k].id);
        EXPECT_EQ(read.nodes[k].position, wanted.nodes[k].position);
      }
      for (std::size_t j = 0; j < read.modes.size(); ++j)
        EXPECT_EQ(read.modes[j].frequency, wanted.modes[j].frequency);
      EXPECT_EQ(read.shapes, wanted.shapes);
    }
    const std::string without = mbs::test::refusal_of([&] { read_flexdata(path); });
    if (n_bodies == 1)
      EXPECT_EQ(without, "accepted");
    else
      EXPECT_THAT(without, HasSubstr(fmt::format("holds {} bodies (id 30101, 30108", n_bodies)));
    EXPECT_THAT(mbs::test::refusal_of([&] { read_flexdata(path, 5); }), HasSubstr("no body of id 5"));
  }
}

TEST_F(FlexDataText, IsRefusedByThePlaceAndTheNameOfWhatIsWrong) {
  const std::string head = "<Reference_FlexData\n\tid='3'\n num_sel_modes=\"1\" num_sel_nodes=\"1\"",
                    rest =
                        ">\n<ModeData>7 1 39.478417604 0</ModeData><NodeData>1 0 0 0 0 0 0 0 0 0</NodeData>"
                        "</Reference_FlexData>\n";
  const auto refusal = [&](const std::string& text) {
    return mbs::test::refusal_of([&] { read_flexdata(file(text, "x.xml")); });
  };
  EXPECT_EQ(refusal(head + rest), "accepted");
  EXPECT_THAT(refusal(head + " id=\"4\"" + rest), HasSubstr("x.xml:3: the attribute id is given twice"));
  EXPECT_THAT(refusal(head + " num_nodes='many'" + rest),
              HasSubstr("x.xml:3: num_nodes = \"many\" is no whole number from 0 on"));
  EXPECT_THAT(refusal("<Reference_FlexData num_sel_modes='1' num_sel_nodes='1'" + rest),
              HasSubstr("x.xml:1: the attribute id = \"number\" is missing"));
  EXPECT_THAT(refusal(head + rest + head + rest), HasSubstr("holds 2 bodies (id 3, 3)"));
  EXPECT_THAT(refusal(head + " x='1" + rest), HasSubstr("the value of x is not closed by a quote"));
  EXPECT_THAT(refusal("<Reference_FlexDatas>" + rest), HasSubstr("holds no Reference_FlexData"));
}

}  // namespace
}  // namespace flexura::superelement
