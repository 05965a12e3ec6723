#include "comms/record.hpp"
