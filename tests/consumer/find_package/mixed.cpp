// SPDX-License-Identifier: Zlib
// Nothing here has a scalar in its signature: only the guard can tell that the library was built for another precision.
#include <BulletISTCollision/Registry/btISTRegistry.h>

int main()
{
	btISTRegistry registry;
	return registry.size();
}
