// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btISTWorld.h"

#include <vector>

namespace browser
{
/// Asks again, in full, what a world has kept instead of asking.
class KeptCheck
{
public:
	/// After each step.
	void look(btISTWorld& world);

	/// Of each pair in each step that was kept while touching: error of the force, as a share of the larger of force and floor
	/// (btISTContactCache). Not in order.
	std::vector<double> errors;
	/// Of kept pairs that had not moved: answers that are not the query's, to the last bit. Only where nothing but exact answers is kept.
	long long changed = 0;
	/// Kept pairs that were thought apart, and touch.
	long long missed = 0;
	long long kept = 0;

	double share(double of);  ///< percentile of the errors; 0 without any
	double largest() { return share(1); }

private:
	ist::QueryWorkspace m_workspace;
};
}  // namespace browser
