#include "common/map/planes.h"

namespace muster::map {
namespace {
constexpr std::uint64_t kFirstOfRow = 0x0001000100010001u, kLastOfRow = 0x8000800080008000u;
}

Plane shifted(const Plane& own, const Plane& next, int face) {
  Plane result;
  for (std::size_t w = 0; w < 64; ++w) {
    const std::size_t y = w & 3;  // four rows of x a word, four words a layer of z
    std::uint64_t v = 0;
    switch (face) {
      case 0:
        v = (own[w] >> 1 & ~kLastOfRow) | (next[w] << 15 & kLastOfRow);
        break;
      case 1:
        v = (own[w] << 1 & ~kFirstOfRow) | (next[w] >> 15 & kFirstOfRow);
        break;
      case 2:
        v = own[w] >> 16 | (y == 3 ? next[w - 3] : own[w + 1]) << 48;
        break;
      case 3:
        v = own[w] << 16 | (y == 0 ? next[w + 3] : own[w - 1]) >> 48;
        break;
      case 4:
        v = w >= 60 ? next[w - 60] : own[w + 4];
        break;
      default:
        v = w < 4 ? next[w + 60] : own[w - 4];
        break;
    }
    result[w] = v;
  }
  return result;
}

}  // namespace muster::map
