#include <air.h>

#include "common/dds/convert.h"
#include "common/dds/wire_fields.h"

namespace muster::dds {

template <class Io, class P>
void fields(const Io& io, air::SeqRange& w, P& p) {
  io(w.first(), p.first);
  io(w.last(), p.last);
}

template <class Io, class P>
void fields(const Io& io, air::DigestEntry& w, P& p) {
  io(w.epoch(), p.author.epoch);
  io(w.complete(), p.complete);
  io(w.author(), p.author.robot);
  io(w.cls(), p.cls);
  io(w.beyond(), p.beyond);
}

template <class Io, class P>
void fields(const Io& io, air::Beacon& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.epoch(), p.epoch);
  io(w.mission_time_s(), p.mission_time);
  io(w.pose(), p.pose);
  io(w.velocity_mps(), p.velocity_mps);
  io(w.role(), p.role);
  io(w.stratum(), p.stratum);
  io(w.activity(), p.activity);
  io(w.radius_m(), p.radius_m);
  io(w.battery(), p.battery);
  io(w.trajectory(), p.trajectory);
  io(w.digest_n(), p.digest_n);
  io(w.digest(), p.digest);
}

template <class Io, class P>
void fields(const Io& io, air::EndEntry& w, P& p) {
  io(w.epoch(), p.author.epoch);
  io(w.complete(), p.complete);
  io(w.author(), p.author.robot);
  io(w.cls(), p.cls);
  io(w.sent(), p.sent);
}

template <class Io, class P>
void fields(const Io& io, air::ExchangeEnd& w, P& p) {
  io(w.envelope(), p.envelope);
  io(w.receiver(), p.receiver);
  io(w.receiver_epoch(), p.receiver_epoch);
  io(w.digest_n(), p.digest_n);
  io(w.first_n(), p.first_n);
  io(w.entries(), p.entries);
}

MUSTER_WHOLE(air, Beacon)
MUSTER_WHOLE(air, ExchangeEnd)

}  // namespace muster::dds
