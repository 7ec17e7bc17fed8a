#include <sim.h>

#include "common/dds/convert.h"
#include "common/dds/wire_fields.h"

namespace muster::dds {

template <class Io, class P>
void fields(const Io& io, sim::Expect& w, P& p) {
  io(w.process(), p.process);
  io(w.bus(), p.bus);
  io(w.air(), p.air);
}

template <class Io, class P>
void fields(const Io& io, sim::Tick& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.k(), p.k);
  io(w.time_s(), p.time);
  io(w.phase(), p.phase);
  io(w.alive(), p.alive);
  io(w.expect(), p.expect);
  io(w.note(), p.note);
}

template <class Io, class P>
void fields(const Io& io, sim::PlanningTime& w, P& p) {
  io(w.step(), p.step);
  io(w.wall_ms(), p.wall_ms);
}

template <class Io, class P>
void fields(const Io& io, sim::Done& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.k(), p.k);
  io(w.process(), p.process);
  io(w.sent_air(), p.sent_air);
  io(w.sent_bus(), p.sent_bus);
  io(w.trace(), p.trace);
  io(w.declares_complete(), p.declares_complete);
  io(w.activity(), p.activity);
  io(w.cpu_ms(), p.cpu_ms);
  io(w.deliveries(), p.deliveries);
  io(w.planning(), p.planning);
}

template <class Io, class P>
void fields(const Io& io, sim::TrueState& w, P& p) {
  io(w.robot(), p.robot);
  io(w.state(), p.state);
  io(w.pose(), p.pose);
  io(w.velocity_mps(), p.velocity_mps);
}

template <class Io, class P>
void fields(const Io& io, sim::Truth& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.k(), p.k);
  io(w.time_s(), p.time);
  io(w.robots(), p.robots);
}

MUSTER_WHOLE(sim, Tick)
MUSTER_WHOLE(sim, Done)
MUSTER_WHOLE(sim, Truth)

}  // namespace muster::dds
