// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Matrices of Nastran: OUTPUT4 in all its forms, and DMIG of bodies that are reduced to modes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstring>

#include "mbs/superelement/exchange/exchange.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/part/read_matrices.hpp"
#include "tests/app/command.hpp"
#include "tests/properties/parts.hpp"
#include "tests/properties/six_dof_models.hpp"

namespace flexura::properties {
namespace {

using testing::HasSubstr;

// How OUTPUT4 may write a matrix.
struct Op4Form {
  bool binary, single, wide, swapped;
  enum Strings { none, small, big } strings;
  int width, per_line;
};

Op4Form random_form(Chance& chance) {
  static constexpr Op4Form::Strings all[] = {Op4Form::none, Op4Form::small, Op4Form::big};
  const bool binary = chance.flip(0.5);
  return {binary,
          chance.flip(0.3),
          binary && chance.flip(0.3),
          binary && chance.flip(0.3),
          chance.one_of(all),
          23 + chance.below(3),
          1 + chance.below(5)};
}

class Op4Writer {
 public:
  explicit Op4Writer(const Op4Form& form) : form_(form) {}

  void add(const std::string& name, const MatrixXd& A) {
    const Index rows = form_.strings == Op4Form::big ? -A.rows() : A.rows();
    if (form_.binary) {
      std::string padded = name;
      padded.resize(form_.wide ? 16 : 8, ' ');
      record(integers({A.cols(), rows, 2, form_.single ? 1 : 2}) + padded);
    } else {
      text_ += fmt::format("{:8}{:8}{:8}{:8}{:<8}1P,{}E{}.16\n", A.cols(), rows, 2, form_.single ? 1 : 2,
                           name, form_.per_line, form_.width);
    }
    for (Index j = 0; j < A.cols(); ++j) {
      std::vector<std::pair<Index, Index>> strings;  // from, number
      for (Index i = 0; i < A.rows(); ++i) {
        if (A(i, j) == 0.0) continue;
        if (!strings.empty() && strings.back().first + strings.back().second == i)
          ++strings.back().second;
        else
          strings.emplace_back(i, 1);
      }
      if (strings.empty()) continue;
      if (form_.strings == Op4Form::none) {
        const Index first = strings.front().first,
                    count = strings.back().first + strings.back().second - first;
        column(j, first + 1, count * (form_.binary ? words() : 1));
        numbers(A.col(j).segment(first, count));
      } else {
        Index n_words = 0;
        for (const auto& string : strings)
          n_words += string.second * words() + (form_.strings == Op4Form::big ? 2 : 1);
        column(j, 0, n_words);
        for (const auto& [first, count] : strings) {
          const std::int64_t length = count * words();
          if (form_.strings == Op4Form::big)
            header({length + 1, first + 1});
          else
            header({(length + 1) * 65536 + first + 1});
          numbers(A.col(j).segment(first, count));
        }
      }
      flush();
    }
    column(A.cols(), 1, form_.binary ? words() : 1);
    numbers(VectorXd::Ones(1));
    flush();
  }
  const std::string& text() const { return text_; }

 private:
  int words() const { return form_.single || form_.wide ? 1 : 2; }
  template <class T>
  std::string bytes(T x) const {
    std::string out(sizeof x, '\0');
    std::memcpy(out.data(), &x, sizeof x);
    if (form_.swapped) std::ranges::reverse(out);
    return out;
  }
  std::string integers(const std::vector<std::int64_t>& all) const {
    std::string out;
    for (const std::int64_t x : all) out += form_.wide ? bytes(x) : bytes(static_cast<std::int32_t>(x));
    return out;
  }
  void record(const std::string& content) {
    const std::string length = bytes(static_cast<std::int32_t>(content.size()));
    text_ += length + content + length;
  }
  void column(Index j, Index row, Index n_words) {
    if (form_.binary)
      open_ = integers({j + 1, row, n_words});
    else
      text_ += fmt::format("{:8}{:8}{:8}\n", j + 1, row, n_words);
  }
  void header(const std::vector<std::int64_t>& all) {
    if (form_.binary) {
      open_ += integers(all);
      return;
    }
    for (const std::int64_t x : all) text_ += fmt::format("{:8}", x);
    text_ += "\n";
  }
  void numbers(const VectorXd& x) {
    for (Index k = 0; k < x.size(); ++k) {
      if (form_.binary) {
        open_ += form_.single && !form_.wide ? bytes(static_cast<float>(x(k))) : bytes(x(k));
        continue;
      }
      text_ += fmt::format("{:{}.16E}", x(k), form_.width);
      if ((k + 1) % form_.per_line == 0 || k + 1 == x.size()) text_ += "\n";
    }
  }
  void flush() {
    if (form_.binary) record(open_);
  }

  const Op4Form form_;
  std::string text_, open_;
};

MatrixXd sparse_matrix(Chance& chance) {
  MatrixXd A = MatrixXd::NullaryExpr(1 + chance.below(12), 1 + chance.below(12),
                                     [&] { return chance.between(-10.0, 10.0); });
  for (double& x : A.reshaped())
    if (chance.flip(0.5)) x = 0.0;
  return A;
}

double difference(const MatrixXd& A, const MatrixXd& B) {
  return A.rows() == B.rows() && A.cols() == B.cols() ? (A - B).cwiseAbs().maxCoeff() : 1e300;
}

TEST(Op4, IsReadInAllItsForms) {
  const test::Folder folder;
  for (int seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Op4Form form = random_form(chance);
    const MatrixXd K = sparse_matrix(chance), M = sparse_matrix(chance), K4 = sparse_matrix(chance);
    Op4Writer several(form);
    several.add("K4GG", K4);
    several.add("KGG", K);
    several.add("MGG", M);
    const auto file = folder.write("m.OP4", several.text());
    // All digits, but for numbers of four bytes.
    const double tolerance = form.binary && form.single && !form.wide ? 1e-6 : 0.0;
    EXPECT_LE(difference(reduce::read_dense(file, 'K'), K), tolerance);
    EXPECT_LE(difference(reduce::read_dense(file, 'M'), M), tolerance);
    EXPECT_THROW(reduce::read_dense(file), std::invalid_argument);  // which of them?
    Op4Writer one(form);
    one.add("PHIG", M);
    EXPECT_LE(difference(reduce::read_dense(folder.write("v.op4", one.text())), M), tolerance);
    // A file that ends too early is refused, unless nothing but the number that ends the matrix is gone.
    const auto cut = static_cast<std::size_t>(1 + chance.below(static_cast<int>(one.text().size()) - 2));
    try {
      static_cast<void>(reduce::read_dense(folder.write("c.op4", one.text().substr(0, cut))));
      EXPECT_GT(cut + static_cast<std::size_t>(form.width) + 2, one.text().size());
    } catch (const std::invalid_argument&) {
    }
    if (testing::Test::HasFailure()) return;
  }
}

// The model by its matrices in OUTPUT4 is that by the same matrices in Matrix Market.
TEST(Op4, OfAModelGivesItsSuperelement) {
  const test::Folder folder;
  for (int seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Model model = random_model(chance);
    Op4Form form = random_form(chance);
    form.single = false;
    Op4Writer writer(form);
    writer.add("KGG", model.K);
    writer.add("MGG", model.M);
    folder.write("m.op4", writer.text());
    folder.write("K.mtx", written(model, model.K, Format::market, "K", chance));
    folder.write("M.mtx", written(model, model.M, Format::market, "M", chance));
    folder.write("nodes.csv", table_of_nodes(model, 1.0));
    const auto reduced = [&](const char* K, const char* M) {
      const std::string text = fmt::format(
          "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n[matrices]\nstiffness = \"{}\"\nmass = \"{}\"\n"
          "[interface.a]\nby = \"nodes\"\nnodes = [{}]\n[modes]\ncount = 4\n",
          K, M, model.label[0]);
      return reduce::reduce(reduce::read_part(folder.write("part.toml", text))).superelement;
    };
    const Superelement one = reduced("m.op4", "m.op4"), other = reduced("K.mtx", "M.mtx");
    // Of both triangles, which differ by round-off, one writer gives the first, the other the second; signs of modes are free.
    EXPECT_LE(difference(one.K_se, other.K_se), 1e-8 * other.K_se.norm());
    EXPECT_LE(difference(one.M_se.cwiseAbs(), other.M_se.cwiseAbs()), 1e-6 * other.M_se.norm());
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Op4, OfAnotherSizeIsRefused) {
  const test::Folder folder;
  Op4Writer writer({false, false, false, false, Op4Form::none, 23, 3});
  writer.add("KAA", MatrixXd::Identity(7, 7));
  folder.write("m.op4", writer.text());
  folder.write("nodes.csv", "1, 0, 0, 0\n2, 1, 0, 0\n");
  const auto part = folder.write(
      "part.toml",
      "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n[matrices]\nstiffness = \"m.op4\"\nmass = "
      "\"m.op4\"\n[interface.a]\nby = \"nodes\"\nnodes = [1]\n");
  try {
    reduce::reduce(reduce::read_part(part));
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("matrix KAA has 7 rows and 7 columns; 6 or 12 are wanted"));
  }
}

// A superelement that is written as DMIG, with grid points and scalar points, is the same body when it is read: stiffness and
// inertia at its interfaces, frequencies, mass, centre and moments.
TEST(ReducedDmig, IsTheBodyThatWasWritten) {
  const test::Folder folder;
  int judged = 0;
  for (int seed = 1; seed <= 400 && judged < 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const RandomPart part =
        random_part(chance, Kind::beams, folder, {.all_directions = true, .fewest_modes = 1});
    if (!part.refused.empty() || part.superelement.n_q == 0) continue;
    const Superelement& se = part.superelement;
    ++judged;
    superelement::write_dmig(folder / "body.pch", se);
    std::string nodes, interfaces;
    for (std::size_t k = 0; k < se.interfaces.size(); ++k) {
      const Vector3d& x = se.interfaces[k].p_BoN_B;
      nodes += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", k + 1, x.x(), x.y(), x.z());
      if (chance.flip(0.5))
        interfaces += fmt::format("[interface.i{0}]\nby = \"nodes\"\nnodes = [{0}]\n", k + 1);
    }
    folder.write("nodes.csv", nodes);
    const std::string text =
        "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n[matrices]\nstiffness = \"body.pch\"\nmass = "
        "\"body.pch\"\n[modes]\ndamping = 0.0\n" +
        interfaces;
    const Superelement read = reduce::reduce(reduce::read_part(folder.write("body.toml", text))).superelement;
    ASSERT_EQ(read.n_b, se.n_b);
    ASSERT_EQ(read.n_q, se.n_q);
    const Index n_b = se.n_b;
    const MatrixXd K = se.K_se.topLeftCorner(n_b, n_b), M = se.M_se.topLeftCorner(n_b, n_b);
    // Ten digits of the file.
    EXPECT_LE((read.K_se.topLeftCorner(n_b, n_b) - K).norm(), 1e-7 * K.norm());
    EXPECT_LT((read.M_se.topLeftCorner(n_b, n_b) - M).norm(), 1e-7 * M.norm());
    EXPECT_NEAR(read.inertia.mass, se.inertia.mass, 1e-7 * se.inertia.mass);
    EXPECT_LT((read.inertia.S_x - se.inertia.S_x).norm(), 1e-6 * (se.inertia.mass + se.inertia.S_x.norm()));
    EXPECT_LT((read.inertia.S_xx - se.inertia.S_xx).norm(),
              1e-6 * (se.inertia.mass + se.inertia.S_xx.norm()));
    // The modes with the interfaces held, whatever their signs, and what they take part in.
    VectorXd right = se.omega2, found = read.omega2;
    std::ranges::sort(right);
    std::ranges::sort(found);
    // Ten digits, brought to the basis again beside stiffnesses of interfaces a thousand times as large.
    EXPECT_LT((found - right).cwiseAbs().maxCoeff(), 1e-6 * right.maxCoeff());
    const auto shared = [&](const Superelement& of) -> MatrixXd {
      return of.M_se.topRightCorner(n_b, of.n_q) * of.M_se.bottomLeftCorner(of.n_q, n_b);
    };
    EXPECT_LT((shared(read) - shared(se)).norm(), 1e-6 * M.norm());
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(judged, 200);
}

TEST(ReducedDmig, IsRefusedWhereItIsHeld) {
  const test::Folder folder;
  std::string text;
  for (const char* name : {"KAAX", "MAAX"}) {
    text += fmt::format("DMIG,{},0,6,2,0\n", name);
    for (int d = 1; d <= 6; ++d)
      text += fmt::format("DMIG,{},1,{},,1,{},{}\n", name, d, d, d < 4 ? "2." : "1.");
    text += fmt::format("DMIG,{},9,0,,9,0,1.\n", name);
  }
  folder.write("body.pch", text);
  folder.write("nodes.csv", "1, 0, 0, 0\n");
  const auto part = folder.write(
      "body.toml",
      "[geometry]\nfile = \"nodes.csv\"\nunit = \"m\"\n[matrices]\nstiffness = \"body.pch\"\nmass = "
      "\"body.pch\"\n");
  const test::Outcome out = test::run("flexura-reduce", {part.string(), "-o", (folder / "b.se.h5").string()});
  EXPECT_NE(out.exit_code, 0);
  EXPECT_THAT(out.err, HasSubstr("the body is held"));
}

}  // namespace
}  // namespace flexura::properties
