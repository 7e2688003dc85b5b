// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/ida/ida.hpp"

#include <fmt/format.h>
#include <ida/ida.h>
#include <ida/ida_impl.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

#include <cmath>
#include <limits>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/integrators/ida/ida_memory.hpp"
#include "mbs/solver/integrators/ida/ida_newton.hpp"
#include "mbs/solver/integrators/newton_matrix.hpp"
#include "mbs/solver/integrators/switches.hpp"

namespace flexura::mbs {

namespace {

// So many steps in a row at a low order, each of which failed at first, are a trap; orders one to five take
// 2 + 3 + 4 + 5 + 6 steps of one length.
constexpr int kTrapped = 5, kHeld = 20;

class Ida final : public Integrator {
 public:
  Ida(const Equations& eq, const SolverOptions& options)
      : eq_(eq), options_(options), weights_(eq, options), switches_(eq) {
    if (SUNContext_Create(nullptr, &context_) != 0)
      throw std::runtime_error("SUNDIALS cannot be initialised");
  }
  ~Ida() override {
    if (memory_ != nullptr) IDAFree(&memory_);
    if (solver_ != nullptr) SUNLinSolFree(solver_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    for (N_Vector x : {y_, yp_, id_, dky_})
      if (x != nullptr) N_VDestroy(x);
    if (context_ != nullptr) SUNContext_Free(&context_);
  }
  Ida(const Ida&) = delete;
  Ida& operator=(const Ida&) = delete;

  void start(const State& s, const Eigen::VectorXd& v_dot) override;
  StepEnd step(double t_stop) override;
  void interpolate(double t, State& s, Eigen::VectorXd& v_dot) override;
  StepCounts counts() const override;
  void remember(History& history) override;

 private:
  void create(const State& s);
  void state_at(double t, State& s);
  void check(int flag, const char* what) const {
    if (flag < 0) throw std::runtime_error(fmt::format("SUNDIALS refuses {}: {}", what, last_message_));
  }
  [[noreturn]] void fail(int flag);
  TangentScope scope();
  void watch_order();
  void leave_trap();
  // What the matrix was last built from, so that it can be built again to the bit.
  struct Built {
    double t = 0.0, cj = 0.0;
    Eigen::VectorXd y, yp;
    TangentScope scope = TangentScope::everything;
  };
  bool build_matrix() {
    form_->linearise(built_.t, built_.y, built_.yp, built_.scope);
    return newton_matrix_->factor(built_.cj);
  }

  static int residual(double t, N_Vector y, N_Vector yp, N_Vector r, void* self);
  static int jacobian(double t, double cj, N_Vector y, N_Vector yp, N_Vector, SUNMatrix, void* self, N_Vector,
                      N_Vector, N_Vector);
  static int weights(N_Vector y, N_Vector w, void* self);
  static void message(int code, const char*, const char*, char* text, void* self);
  static Ida& of(void* self) { return *static_cast<Ida*>(self); }
  // Runs a callback that may throw; nothing passes through C code.  A state at which the model cannot be
  // evaluated is a reason to try a shorter step (1); if that does not help, fail() repeats what the model
  // said.
  template <class F>
  int guarded(F&& f) {
    try {
      trouble_.clear();
      return f();
    } catch (const std::bad_alloc&) {
      // No step is short enough for that, and what was to grow is in no state to be used again.
      fatal_ = std::current_exception();
      return -1;
    } catch (const std::exception& e) {
      trouble_ = e.what();
      return 1;
    }
  }

  const Equations& eq_;
  SolverOptions options_;
  ErrorWeights weights_;
  SwitchFinder switches_;
  std::unique_ptr<StabilisedIndex2> form_;
  std::unique_ptr<NewtonMatrix<double>> newton_matrix_;
  SUNContext context_ = nullptr;
  void* memory_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  N_Vector y_ = nullptr, yp_ = nullptr, id_ = nullptr, dky_ = nullptr;
  double t_ = 0.0;
  StepCounts before_;  // of earlier starts: IDA counts from its last start
  Built built_;
  State start_;  // of the last (re)start: the scale S of the form and the switches
  long failures_seen_ = 0;
  int full_matrices_left_ = 0;
  long errors_seen_ = 0;
  int trapped_ = 0, held_left_ = 0;  // steps at a low order that failed once; steps still held at one length
  std::string last_message_;
  std::exception_ptr fatal_;
  std::string trouble_;  // why the last evaluation failed, or empty
};

int Ida::residual(double t, N_Vector y, N_Vector yp, N_Vector r, void* self) {
  Ida& ida = of(self);
  return ida.guarded([&] {
    if (ida.form_->residual(t, view(y), view(yp), edit(r))) return 0;
    ida.trouble_ = ida.form_->non_finite();
    return 1;
  });
}

int Ida::jacobian(double t, double cj, N_Vector y, N_Vector yp, N_Vector, SUNMatrix, void* self, N_Vector,
                  N_Vector, N_Vector) {
  Ida& ida = of(self);
  ida.built_.t = t;
  ida.built_.cj = cj;
  ida.built_.y = view(y);
  ida.built_.yp = view(yp);
  ida.built_.scope = ida.scope();
  return ida.guarded([&] { return ida.build_matrix() ? 0 : 1; });
}

// The cheap matrix, which holds of elastic coordinates their stiffness alone, until Newton's method fails
// with it; then the full one for a while.
TangentScope Ida::scope() {
  long failures = 0;
  IDAGetNumNonlinSolvConvFails(memory_, &failures);
  if (failures > failures_seen_) {
    full_matrices_left_ = 20;
    form_->forget_structure();
  }
  failures_seen_ = failures;
  if (!form_->has_elastic_coordinates()) return TangentScope::everything;
  if (full_matrices_left_ == 0) return TangentScope::newton;
  --full_matrices_left_;
  return TangentScope::everything;
}

int Ida::weights(N_Vector y, N_Vector w, void* self) {
  Ida& ida = of(self);
  const StabilisedIndex2& form = *ida.form_;
  const int n_p = form.at_v(), n_v = form.at_c() - n_p, n_c = form.at_a() - form.at_c();
  const auto in = view(y);
  auto out = edit(w);
  ida.weights_.evaluate(in.head(n_p), in.segment(n_p, n_v), in.segment(form.at_c(), n_c),
                        out.head(form.at_a()));
  for (int i = form.at_a(); i < form.at_lambda(); ++i)
    out(i) = 1.0 / (ida.options_.tolerance * (std::abs(in(i)) + ida.options_.absolute_factor));
  // Multipliers follow linearly from the rest: they neither steer the step nor stop Newton.  The norm divides
  // by the length of y; the factor takes them out of that count too.
  out.tail(2 * form.n_lambda()).setConstant(1e-30);
  if (form.at_lambda() > 0)
    out.head(form.at_lambda()) *= std::sqrt(static_cast<double>(form.size()) / form.at_lambda());
  return out.allFinite() ? 0 : -1;
}

void Ida::message(int, const char*, const char*, char* text, void* self) {
  of(self).last_message_ = text;
}

void Ida::create(const State& s) {
  form_ = std::make_unique<StabilisedIndex2>(eq_, s);
  newton_matrix_ = std::make_unique<NewtonMatrix<double>>(*form_);
  const int n = form_->size();
  y_ = N_VNew_Serial(n, context_);
  yp_ = N_VNew_Serial(n, context_);
  id_ = N_VNew_Serial(n, context_);
  dky_ = N_VNew_Serial(n, context_);
  edit(y_).setZero();
  edit(yp_).setZero();
  edit(id_).setZero();
  edit(id_).head(form_->at_a()).setOnes();

  memory_ = IDACreate(context_);
  if (memory_ == nullptr) throw std::runtime_error("SUNDIALS cannot allocate an integrator");
  check(IDASetErrHandlerFn(memory_, &Ida::message, this), "its error handler");
  check(IDAInit(memory_, &Ida::residual, s.t, y_, yp_), "the initial values");
  check(IDASetUserData(memory_, this), "its user data");
  // Orders that were never reached are part of the history all the same.
  auto* const record = static_cast<IDAMem>(memory_);
  for (int k = 0; k <= record->ida_maxord; ++k) N_VConst(0.0, record->ida_phi[k]);
  N_VConst(0.0, record->ida_ee);
  check(IDAWFtolerances(memory_, &Ida::weights), "the error weights");
  check(IDASetId(memory_, id_), "the kinds of states");
  check(IDASetSuppressAlg(memory_, SUNTRUE), "the error test's mask");
  check(IDASetMaxOrd(memory_, options_.max_order), "max_order");
  check(IDASetMaxNumSteps(memory_, -1), "the number of steps");
  check(IDASetMaxErrTestFails(memory_, 20), "the number of failures");
  check(IDASetMaxConvFails(memory_, 25), "the number of failures");
  const double duration = options_.end_time - options_.start_time;
  check(IDASetMaxStep(memory_, options_.longest_step()), "max_step");
  // A load that begins on a mechanism at rest, where errors are allowed in parts of nothing, wants the shortest
  // first step that times can tell apart: 1 MN that rises within a microsecond, 1e-12 of 10 s and less.
  check(IDASetMinStep(memory_, options_.min_step > 0.0 ? options_.min_step : 1e-15 * duration), "min_step");
  // Newton down to a hundredth of the error allowed (IDA's own choice is a third): what it leaves behind is
  // noise in accelerations and multipliers, which costs more steps than the iterations do (Andrews: 40 %
  // fewer steps at the same number of evaluations) and spoils the work of drives.
  check(IDASetNonlinConvCoef(memory_, 0.01), "Newton's tolerance");

  matrix_ = make_empty_matrix(context_);
  solver_ = make_newton_solver(context_, *newton_matrix_);
  check(IDASetLinearSolver(memory_, solver_, matrix_), "the linear solver");
  check(IDASetJacFn(memory_, &Ida::jacobian), "the Jacobian");
}

void Ida::start(const State& s, const Eigen::VectorXd& v_dot) {
  if (memory_ == nullptr) {
    create(s);
  } else {
    const StepCounts sum = counts();
    before_ = sum;
    before_.evaluations = 0;
    ++before_.restarts;
    form_->set_start(s);
  }
  failures_seen_ = 0;
  start_ = s;
  weights_.start(s, v_dot);
  leave_trap();
  switches_.start(s);
  form_->pack(s, v_dot, edit(y_), edit(yp_));
  check(IDAReInit(memory_, s.t, y_, yp_), "the initial values");
  check(IDASetInitStep(memory_, options_.first_step), "first_step");
  t_ = s.t;
}

StepEnd Ida::step(double t_stop) {
  StepEnd end;
  end.t_begin = t_;
  check(IDASetStopTime(memory_, t_stop), "the end time");
  double t = t_;
  const int flag = IDASolve(memory_, t_stop, &t, y_, yp_, IDA_ONE_STEP);
  if (flag < 0) fail(flag);
  if (!view(y_).allFinite())
    throw IntegrationError(fmt::format("the state is no longer finite at t = {:.9g} s", t));
  end.t_end = t;
  const int n_p = form_->at_v();
  weights_.take(view(y_).head(n_p), view(y_).segment(n_p, form_->at_c() - n_p));
  watch_order();
  // IDA has a root finder of its own, which overlooks a function that leaves an exact 0.
  switches_.search(end, [&](double at, State& s) { state_at(at, s); });
  t_ = end.t_end;
  return end;
}

// IDA lengthens its steps by nothing less than a factor of two, and lifts its order only after as many steps
// of one length as the order.  Of a stiff contact the velocities follow from the positions, (p_n - p_n-1) / h at
// order one, with an error that goes with h: a step twice as long brings a jump of that error, fails, and the
// count of equal steps begins anew, for ever at order one.  Steps held at one length for a while let the order
// rise, and the jump shrinks with it.
void Ida::watch_order() {
  long errors = 0;
  int order = 0;
  double h = 0.0;
  IDAGetNumErrTestFails(memory_, &errors);
  IDAGetLastOrder(memory_, &order);
  IDAGetLastStep(memory_, &h);
  trapped_ = errors > errors_seen_ && order < std::min(3, options_.max_order) ? trapped_ + 1 : 0;
  errors_seen_ = errors;
  if (held_left_ > 0 && --held_left_ == 0) check(IDASetMaxStep(memory_, options_.longest_step()), "max_step");
  if (trapped_ < kTrapped || held_left_ > 0) return;
  check(IDASetMaxStep(memory_, h), "max_step");
  held_left_ = kHeld;
  trapped_ = 0;
}

void Ida::leave_trap() {
  if (held_left_ > 0) check(IDASetMaxStep(memory_, options_.longest_step()), "max_step");
  trapped_ = held_left_ = 0;
  errors_seen_ = 0;
}

void Ida::fail(int flag) {
  double t = t_, h = 0.0;
  IDAGetCurrentTime(memory_, &t);
  IDAGetCurrentStep(memory_, &h);
  if (fatal_) std::rethrow_exception(fatal_);
  if (!trouble_.empty()) throw IntegrationError(trouble_);
  // The state with the largest error or correction is the best hint at the element in trouble.
  std::string worst;
  // A mechanism that is welded all over has none.
  if (form_->at_a() > 0 && IDAGetEstLocalErrors(memory_, dky_) == IDA_SUCCESS) {
    N_Vector weight = N_VNew_Serial(form_->size(), context_);
    if (IDAGetErrWeights(memory_, weight) == IDA_SUCCESS) {
      int i = 0;
      view(dky_).cwiseProduct(view(weight)).head(form_->at_a()).cwiseAbs().maxCoeff(&i);
      worst = i < form_->at_v()   ? eq_.name_of_position(i)
              : i < form_->at_c() ? eq_.name_of_velocity(i - form_->at_v())
                                  : eq_.name_of_dynamic(i - form_->at_c());
    }
    N_VDestroy(weight);
  }
  const std::string where =
      fmt::format("t = {:.9g} s with steps of {:.3g} s{}", t, std::abs(h),
                  worst.empty() ? std::string() : fmt::format("; the state in trouble is \"{}\"", worst));
  switch (flag) {
    case IDA_ERR_FAIL:
      throw IntegrationError("the error test keeps failing at " + where +
                             ": a force jumps there; give it a switch or smooth it, or loosen the tolerance");
    case IDA_CONV_FAIL:
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      throw IntegrationError(
          "Newton's method does not converge at " + where +
          ": a force jumps there, or the mechanism is in a position where its constraints lose rank");
    case IDA_REP_RES_ERR:
      throw IntegrationError("the forces cannot be evaluated at " + where);
    case IDA_TOO_MUCH_ACC:
      throw IntegrationError("the tolerance is below what double precision can meet at " + where +
                             ": give a larger tolerance or absolute_factor");
    default:
      throw IntegrationError(fmt::format("the integrator stops at {}: {}", where, last_message_));
  }
}

void Ida::state_at(double t, State& s) {
  check(IDAGetDky(memory_, t, 0, dky_), "the time to interpolate at");
  form_->unpack(t, view(dky_), s);
}

void Ida::interpolate(double t, State& s, Eigen::VectorXd& v_dot) {
  state_at(t, s);
  check(IDAGetDky(memory_, t, 1, dky_), "the time to interpolate at");
  v_dot = view(dky_).segment(form_->at_v(), form_->at_c() - form_->at_v());
}

StepCounts Ida::counts() const {
  StepCounts c = before_;
  if (memory_ == nullptr) return c;
  long steps = 0, setups = 0, errors = 0, failures = 0;
  IDAGetNumSteps(memory_, &steps);
  IDAGetNumLinSolvSetups(memory_, &setups);
  IDAGetNumErrTestFails(memory_, &errors);
  IDAGetNumNonlinSolvConvFails(memory_, &failures);
  c.steps += steps;
  c.jacobians += setups;
  c.error_failures += errors;
  c.newton_failures += failures;
  c.evaluations = form_->evaluations();
  return c;
}

void Ida::remember(History& history) {
  if (!history.reads() && memory_ == nullptr) return;  // it never started
  mbs::remember(history, start_, eq_.sizes());
  weights_.remember(history);
  history(trapped_);
  history(held_left_);
  if (history.reads()) {
    create(start_);
    form_->set_start(start_);
  }
  auto* m = static_cast<IDAMem>(memory_);
  const long n = form_->size();
  history.all(NV_DATA_S(y_), n);
  history.all(NV_DATA_S(yp_), n);
  if (history.reads()) {
    // IDA sets itself up in its first step; everything that step leaves is overwritten below.
    double t = start_.t;
    Eigen::VectorXd y = view(y_), yp = view(yp_);
    check(IDAReInit(memory_, start_.t, y_, yp_), "the initial values");
    check(IDASetInitStep(memory_, 1e-9 * (options_.end_time - options_.start_time)), "first_step");
    check(IDASetStopTime(memory_, start_.t + 2.0 * (options_.end_time - options_.start_time)),
          "the end time");
    IDASolve(memory_, options_.end_time, &t, y_, yp_, IDA_ONE_STEP);
    edit(y_) = y;
    edit(yp_) = yp;
  }
  remember_ida(history, *m, n);
  switches_.remember(history, start_);
  history(built_.t);
  history(built_.cj);
  history(built_.y);
  history(built_.yp);
  int scope = built_.scope == TangentScope::newton ? 1 : 0;
  history(scope);
  history(full_matrices_left_);
  history(t_);
  if (!history.reads()) return;
  // Saved before its first step, it had built none.
  const bool is_built = m->ida_nst > 0 || built_.y.size() > 0;
  for (const Eigen::VectorXd* x : {&built_.y, &built_.yp}) require_size(x->size(), is_built ? n : 0);
  built_.scope = scope == 1 ? TangentScope::newton : TangentScope::everything;
  IDAGetNumNonlinSolvConvFails(memory_, &failures_seen_);
  IDAGetNumErrTestFails(memory_, &errors_seen_);
  if (is_built) build_matrix();
}

}  // namespace

std::unique_ptr<Integrator> make_ida(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<Ida>(eq, options);
}

}  // namespace flexura::mbs
