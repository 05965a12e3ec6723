#pragma once
#include "scene.hpp"

// Pieces in the builder's local coordinates: the back in the middle of y = 0 unless said otherwise, on the floor.
namespace onemap::hal::simulated {

void bookshelf(SceneBuilder& b, double width, double height);
void sofa(SceneBuilder& b, double width);
void armchair(SceneBuilder& b);
void cupboard(SceneBuilder& b, double width, double height);
void sideboard(SceneBuilder& b, double width);                           // low, with a screen and things on it
void desk(SceneBuilder& b, double width);                                // with a screen, papers, a lamp
void rack(SceneBuilder& b, double width);                                // shelves of crates and cans
void table(SceneBuilder& b, double width, double depth, double height);  // middle at y = 0, with things on it
void floor_lamp(SceneBuilder& b);                                        // middle at y = 0
void plant(SceneBuilder& b);                                             // middle at y = 0
void box_stack(SceneBuilder& b, int boxes);                              // middle at y = 0
void barrel(SceneBuilder& b);                                            // middle at y = 0
void hanging(SceneBuilder& b, double x, double z, double width, double height, Style style);  // on the wall
void hangings(SceneBuilder& b, double x0, double x1, double z0, double z1, Style style);      // a row of them
void rug(SceneBuilder& b, double width, double depth);                                        // middle at y = 0

}  // namespace onemap::hal::simulated
