#pragma once

namespace onemap::daemon {

// Has the C library give back what is freed, so that a daemon that works for days does not grow by holes between what
// lives long: two arenas for all threads, blocks of half a megabyte and more from the system and back to it. By itself
// it takes an arena a thread, and larger and larger blocks from them. At the start of main, before threads.
void give_memory_back();

}  // namespace onemap::daemon
