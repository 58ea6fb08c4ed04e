// SPDX-License-Identifier: Zlib
#pragma once

/// The virtual table of the results that Bullet passes to algorithms within its contact tests (contactTest, contactPairTest). Their class
/// is local to a source of Bullet's, so an algorithm of ours is called by such a test, once.
/// Cost: a few allocations in the first call.
const void* btISTTableOfContactTests();
