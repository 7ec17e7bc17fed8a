#include "agent/agent.h"
#include "common/dds/robot_cli.h"

int main(int argc, char** argv) {
  return muster::dds::robot_main(argc, argv, "muster-agent",
                                 "muster-agent: one robot, explorer or inspector. The same program "
                                 "flies in `muster run` and on a "
                                 "drone's computer.",
                                 false, muster::agent::make_agent);
}
