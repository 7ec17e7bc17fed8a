#include <bus.h>

#include "common/dds/convert.h"
#include "common/dds/wire_fields.h"

namespace muster::dds {

template <class Io, class P>
void fields(const Io& io, bus::Odometry& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.time_s(), p.time);
  io(w.pose(), p.pose);
  io(w.velocity_mps(), p.velocity_mps);
  io(w.yaw_rate_radps(), p.yaw_rate_radps);
  io(w.state(), p.state);
}

template <class Io, class P>
void fields(const Io& io, bus::Scan& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.time_s(), p.time);
  io(w.sensor(), p.sensor);
  io(w.pitch_rad(), p.pitch_rad);
  io(w.kind(), p.kind);
  io(w.columns(), p.columns);
  io(w.rows(), p.rows);
  io(w.hfov_rad(), p.hfov_rad);
  io(w.vfov_rad(), p.vfov_rad);
  io(w.range_m(), p.range_m);
  io(w.range_mm(), p.range_mm);
}

template <class Io, class P>
void fields(const Io& io, bus::Sighting& w, P& p) {
  io(w.position(), p.position);
  io(w.feature_type(), p.feature_type);
  io(w.priority(), p.priority);
  io(w.skill(), p.skill);
}

template <class Io, class P>
void fields(const Io& io, bus::Sightings& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.time_s(), p.time);
  io(w.sensor(), p.sensor);
  io(w.pitch_rad(), p.pitch_rad);
  io(w.seen(), p.seen);
}

template <class Io, class P>
void fields(const Io& io, bus::Battery& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.time_s(), p.time);
  io(w.charge(), p.charge);
  io(w.capacity_mah(), p.capacity_mah);
  io(w.charging(), p.charging);
  io(w.station(), p.station);
}

template <class Io, class P>
void fields(const Io& io, bus::FoundFeature& w, P& p) {
  io(w.feature(), p.feature);
  io(w.feature_type(), p.feature_type);
  io(w.position(), p.position);
}

template <class Io, class P>
void fields(const Io& io, bus::Inspected& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.time_s(), p.time);
  io(w.request(), p.request);
  io(w.outcome(), p.outcome);
  io(w.found(), p.found);
  io(w.payload(), p.payload);
}

template <class Io, class P>
void fields(const Io& io, bus::OperatorRequest& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.verb(), p.verb);
  io(w.robot(), p.robot);
}

template <class Io, class P>
void fields(const Io& io, bus::TimedState& w, P& p) {
  io(w.t_s(), p.t);
  io(w.p(), p.p);
  io(w.v_mps(), p.v_mps);
  io(w.yaw_rad(), p.yaw_rad);
}

template <class Io, class P>
void fields(const Io& io, bus::Trajectory& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.id(), p.id);
  io(w.land(), p.land);
  io(w.states(), p.states);
}

template <class Io, class P>
void fields(const Io& io, bus::Inspect& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.request(), p.request);
  io(w.area(), p.area);
  io(w.hold_s(), p.hold_s);
}

template <class Io, class P>
void fields(const Io& io, bus::Charge& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.station(), p.station);
}

MUSTER_WHOLE(bus, Odometry)
MUSTER_WHOLE(bus, Scan)
MUSTER_WHOLE(bus, Sightings)
MUSTER_WHOLE(bus, Battery)
MUSTER_WHOLE(bus, Inspected)
MUSTER_WHOLE(bus, OperatorRequest)
MUSTER_WHOLE(bus, Trajectory)
MUSTER_WHOLE(bus, Inspect)
MUSTER_WHOLE(bus, Charge)

}  // namespace muster::dds
