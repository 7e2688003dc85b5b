// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/ida/ida_memory.hpp"

#include <nvector/nvector_serial.h>

#include <limits>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

void remember_ida(History& history, IDAMemRec& record, long n) {
  IDAMemRec* const m = &record;
  for (int k = 0; k <= m->ida_maxord; ++k) history.all(NV_DATA_S(m->ida_phi[k]), n);
  history.all(NV_DATA_S(m->ida_ee), n);
  for (double* x : {m->ida_psi, m->ida_alpha, m->ida_beta, m->ida_sigma, m->ida_gamma})
    history.all(x, MXORDP1);
  for (int* x : {&m->ida_kk, &m->ida_kused, &m->ida_knew, &m->ida_phase, &m->ida_ns}) history(*x);
  for (double* x :
       {&m->ida_hin, &m->ida_h0u, &m->ida_hh, &m->ida_hused, &m->ida_eta, &m->ida_tn, &m->ida_tretlast,
        &m->ida_cj, &m->ida_cjlast, &m->ida_cjold, &m->ida_cjratio, &m->ida_ss, &m->ida_oldnrm,
        &m->ida_epsNewt, &m->ida_toldel, &m->ida_hmax_inv, &m->ida_hmin, &m->ida_tolsf})
    history(*x);
  history(m->ida_nst);
  if (!history.reads()) return;
  for (const int order : {m->ida_kk, m->ida_kused, m->ida_knew}) require_between(order, 0, m->ida_maxord);
  require_between(m->ida_ns, 0, m->ida_maxord + 2);
  require_between(m->ida_phase, 0, 1);
  require_between(m->ida_nst, 0, std::numeric_limits<long>::max());
}

}  // namespace flexura::mbs
