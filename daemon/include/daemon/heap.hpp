#pragma once

namespace onemap::daemon {

// Has the C library give back what is freed, so that a daemon that works for days does not grow by holes between what
// lives long: two arenas for all threads, blocks of 12 kB and more (records' bodies) from the system and back to it. By
// itself it takes an arena a thread, and larger and larger blocks from them. At the start of main, before threads.
void give_memory_back();

// What is free between what lives long goes back to the system now, page by page; some milliseconds, in which a thread
// that allocates may wait. For now and then.
void give_back_holes();

// The other way, for a program that works for a moment on large arrays: what is freed is used again rather than given
// back, and comes in huge pages where the system has such. At the start of main, before there is much on the heap.
void keep_memory();

}  // namespace onemap::daemon
