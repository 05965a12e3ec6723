#include "control/ctl.hpp"

int main(int argc, char** argv) { return onemap::control::run_ctl(argc, argv); }
