#pragma once
// OpenNI2's driver interface leaves it to the driver how objects are made.
#include <new>
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <OniPlatform.h>

#include <Driver/OniDriverAPI.h>
