#include "common/dds/robot_cli.h"
#include "gcs/station.h"

int main(int argc, char** argv) {
  return muster::dds::robot_main(argc, argv, "muster-gcs",
                                 "muster-gcs: the ground station. Assigns, meets, collects, and "
                                 "declares the mission complete.",
                                 true, muster::gcs::make_station);
}
