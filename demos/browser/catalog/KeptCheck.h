// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"

#include <vector>

namespace browser
{
/// Repeats as full queries what a world has taken from its contact cache, and compares.
class KeptCheck
{
public:
	/// Checks all contacts of the world; call it after each step.
	void look(btISTWorld& world);

	/// Error of the force for each step of each touching pair with a cached result, as a share of the larger of force and floor
	/// (btISTContactCache). Unordered.
	std::vector<double> errors;
	/// Number of cached results of pairs that have not moved and that differ from the query in any bit. Counted only where the cache
	/// keeps exact answers alone.
	long long changed = 0;
	/// Number of pairs that the cache took for separate although they share a volume.
	long long missed = 0;
	long long kept = 0;

	double share(double of);  ///< quantile of the errors for the share `of`; 0 without any
	double largest() { return share(1); }

private:
	ist::QueryWorkspace m_workspace;
};
}  // namespace browser
