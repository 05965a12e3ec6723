#pragma once
#include "hal/base/twin.hpp"
