#include "common/dds/robot_cli.h"
#include "tests/fleet/hopper.h"

int main(int argc, char** argv) {
  return muster::dds::robot_main(argc, argv, "muster-gcs", "a station among hoppers", true,
                                 muster::test::make_hopper);
}
