// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Geometry/SpherePacking.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ist
{
/// Finds the sphere with the smallest |p - c| - r among spheres that do not overlap. Immutable after construction: any number of threads
/// may query.
class NearestSphere
{
public:
	struct Hit
	{
		uint32_t sphere = UINT32_MAX;  ///< lowest index among equally near spheres
		double distance = 1e300;       ///< |p - c| - r; negative inside the sphere
	};

	explicit NearestSphere(const std::vector<Sphere>& spheres);

	/// `hint`: any sphere that is likely to be near. It changes the time taken, never the result.
	Hit nearest(const Vec3& p, uint32_t hint = UINT32_MAX) const;

	/// The spheres that can be nearest to a point of a ball, for many queries close together.
	struct Neighbourhood
	{
		Vec3 center;
		double radius = 0;
		std::vector<std::pair<double, uint32_t>> spheres;  ///< sorted by distance from the centre; second: index of the entry
		bool complete = false;                             ///< false: there are too many spheres, and the list is empty
	};
	void gather(const Vec3& center, double radius, Neighbourhood& out, uint32_t hint = UINT32_MAX) const;
	/// Returns what nearest(p, hint) returns. `p` must lie in the ball of `near`.
	Hit nearest(const Vec3& p, const Neighbourhood& near, uint32_t hint = UINT32_MAX) const;

private:
	struct Node
	{
		Vec3 centerLower, centerUpper;  // box of the balls' centres
		double largestRadius = 0;
		uint32_t first = 0, count = 0;  // count > 0: leaf
		uint32_t right = 0;             // the left child follows its parent
	};
	struct Entry
	{
		Vec3 center;
		double radius;
		uint32_t sphere;

		void offer(const Vec3& p, Hit& best) const
		{
			const double d = distance(p, center) - radius;
			if (d < best.distance || (d == best.distance && sphere < best.sphere)) best = {sphere, d};
		}
	};

	uint32_t build(uint32_t first, uint32_t last);
	static double lowerBound(const Node& node, const Vec3& p);

	std::vector<Node> m_nodes;
	std::vector<Entry> m_entries;
	std::vector<uint32_t> m_roots;
	std::vector<uint32_t> m_slots;  // entry of each sphere
	double m_slack = 0;             // much larger than rounding, much smaller than any gap [m]
};
}  // namespace ist
