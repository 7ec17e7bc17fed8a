#pragma once

#include "common/core/yaml.h"
#include "commsim/world/generator_solids.h"

/// The things a recipe can ask for. Each reads its own keys from the mapping, stands on z = 0
/// around the origin of the current frame and faces −y. Passages are at least 1.6 m wide, so that a
/// body of 0.25 m fits with room to spare.
namespace muster::world::parts {

// generator_primitives.cpp
void box(YamlMap& map, Solids& out);
void column(YamlMap& map, Solids& out);
void cone(YamlMap& map, Solids& out);
void gable_roof(YamlMap& map, Solids& out);
void hip_roof(YamlMap& map, Solids& out);
void arch(YamlMap& map, Solids& out);
void wall(YamlMap& map, Solids& out);
void stairs(YamlMap& map, Solids& out);
void tree(YamlMap& map, Solids& out);

// generator_temple.cpp
void hall(YamlMap& map, Solids& out);
void pagoda(YamlMap& map, Solids& out);
void paifang(YamlMap& map, Solids& out);
void gallery(YamlMap& map, Solids& out);

// generator_town.cpp
void house(YamlMap& map, Solids& out);
void tower(YamlMap& map, Solids& out);
void church(YamlMap& map, Solids& out);
void rampart(YamlMap& map, Solids& out);

/// Steps of 0.2 m down to the ground in front of y = `front_y`, for a floor at `height`.
void steps(Solids& out, double width, double front_y, double height);
/// Merlons along x between `x0` and `x1`, standing on z.
void merlons(Solids& out, double x0, double x1, double y, double z, double thickness);

/// A key that must be above 0.
double positive(YamlMap& map, const std::string& key, double fallback);
int count(YamlMap& map, const std::string& key, int fallback, int low, int high);

}  // namespace muster::world::parts
