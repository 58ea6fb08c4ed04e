// SPDX-License-Identifier: Zlib
#pragma once

class btCollisionDispatcher;
class btDispatcher;

// What class a dispatcher has, with and without RTTI (Registry/btISTClassOf.h).

/// The dispatcher as one with tables of create functions, or null if it has none or cannot be recognised.
btCollisionDispatcher* btISTAsCollisionDispatcher(btDispatcher* dispatcher);

/// Whether the dispatcher may call algorithms from several threads at once. Without RTTI, a class derived from Bullet's threaded
/// dispatcher is not recognised.
bool btISTIsThreaded(const btCollisionDispatcher& dispatcher);
