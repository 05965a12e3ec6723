#pragma once
#include "sim/sim_net.hpp"
