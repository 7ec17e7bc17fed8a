#include "common/store/shelf.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/core/error.h"

namespace muster::store {

Shelf::Shelf(const std::string& dir) {
  std::string name = dir + "/.shelf-XXXXXX";
  file_ = mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) throw Failure(dir + ": no file can be made there: " + std::strerror(errno));
  unlink(name.c_str());
}

Shelf::~Shelf() { close(file_); }

std::optional<Shelf::Place> Shelf::put(ByteView bytes) {
  const Place place{end_, bytes.size()};
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = pwrite(file_, bytes.data() + done, bytes.size() - done,
                             static_cast<off_t>(place.offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return std::nullopt;
    done += static_cast<std::size_t>(n);
  }
  end_ += bytes.size();
  return place;
}

Bytes Shelf::get(const Place& place) const {
  Bytes bytes(place.size);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = pread(file_, bytes.data() + done, bytes.size() - done,
                            static_cast<off_t>(place.offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw Failure("a record's body cannot be read back from disk");
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

}  // namespace muster::store
