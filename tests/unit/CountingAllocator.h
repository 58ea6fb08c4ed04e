// SPDX-License-Identifier: Zlib
#pragma once

/// Calls of operator new in this program so far, by any thread. Linking CountingAllocator.cpp replaces the global operators.
long allocationCount();
/// Of these, without a call of operator delete so far.
long liveAllocations();
