#include "render/scene.hpp"
