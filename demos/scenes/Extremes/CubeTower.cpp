// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/CubeTower.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Extremes/ExtremeRows.h"

#include <algorithm>
#include <cmath>

namespace scenes
{
namespace
{
constexpr double kGravity = 9.81;

class Tower
{
public:
	Tower(Response response, const ExtremeSolid& cube, const TowerSetup& s)
		: m_setup(s),
		  m_cube(cube),
		  m_plain{cube.mesh, nullptr},
		  m_world(response),
		  m_edge(ist::bounds(cube.mesh).longestSide())
	{
		m_world.addFloor();
		double height = 0, above = (s.cubes - 1) * s.mass + s.topMass;
		for (int i = 0; i < s.cubes; ++i)
		{
			const double mass = i + 1 == s.cubes ? s.topMass : s.mass, k = stiffness(i), load = above * kGravity;
			m_expected.push_back(modelSinkage(solid(i), i == 0 ? nullptr : &solid(i - 1), k, load, s.turn));
			m_volumes.push_back(load / k);
			height += (i == 0 ? m_edge / 2 : m_edge) - (response == Response::Volumetric ? m_expected.back() : 0);
			m_start.push_back({3, height, -2});
			m_bodies.push_back(
				m_world.add(solid(i), mass, mass * m_edge * m_edge / 6, transformOf(m_start.back(), {0, s.turn * i, 0}), 2 * s.k));
			above -= mass;
		}
	}

	TowerOutcome run()
	{
		TowerOutcome out;
		out.expected = m_expected;
		const int steps = int(m_setup.seconds / m_setup.h + 0.5);
		for (int i = 0; i < steps && out.finite && out.fellAfter < 0; ++i)
		{
			m_world.step(m_setup.h);
			for (size_t b = 0; b < m_bodies.size(); ++b)
			{
				const ist::Vec3 moved = position(b) - m_start[b];
				out.finite = out.finite && ist::isFinite(moved);
				out.drift = std::max(out.drift, std::hypot(moved.x, moved.z) / m_edge);
			}
			if (position(m_bodies.size() - 1).y < m_start.back().y - m_edge / 2) out.fellAfter = (i + 1) * m_setup.h;
		}
		judge(out);
		return out;
	}

private:
	const ExtremeSolid& solid(int i) const { return m_setup.plainBetween && i % 2 == 1 ? m_plain : m_cube; }
	ist::Vec3 position(size_t b) const { return toVec3(m_bodies[b]->getWorldTransform().getOrigin()); }

	/// Stiffness of the contact below cube `i`. Materials act in series, so each body has 2 k and the plane has none. Without a set
	/// stiffness it is that of the default rule for two bodies with these trees.
	double stiffness(int i) const
	{
		const TowerSetup& s = m_setup;
		if (s.k > 0) return i == 0 ? 2 * s.k : s.k;
		const double gap = (i == 0 ? 1 : 2) * m_cube.tree->meanGap, depth = std::clamp(gap, 1e-3 * m_edge, 5e-3 * m_edge);
		return ((s.cubes - 1) * s.mass + s.topMass) * kGravity / (depth * m_edge * m_edge);
	}

	void judge(TowerOutcome& out) const
	{
		out.lowest = 1e300;
		for (size_t b = 0; b < m_bodies.size(); ++b)
		{
			const double under = b == 0 ? -m_edge / 2 : position(b - 1).y;
			out.sinkage.push_back(m_edge - (position(b).y - under));
			if (b == 0) continue;
			out.lowest = std::min(out.lowest, (position(b).y - under) / m_edge);
			if (m_world.response() != Response::Volumetric || out.fellAfter >= 0) continue;
			const ist::Pose X_WA = toPose(m_bodies[b]->getWorldTransform()), X_WB = toPose(m_bodies[b - 1]->getWorldTransform());
			const double force = modelForceUp(solid(int(b)), X_WA, solid(int(b) - 1), X_WB, 1);
			out.forceError = std::max(out.forceError, std::fabs(force / m_volumes[b] - 1));
		}
	}

	TowerSetup m_setup;
	const ExtremeSolid& m_cube;
	ExtremeSolid m_plain;
	ExtremeWorld m_world;
	double m_edge;
	std::vector<btRigidBody*> m_bodies;
	std::vector<ist::Vec3> m_start;
	std::vector<double> m_expected, m_volumes;  // load / k
};
}  // namespace

TowerOutcome stackCubes(Response response, const ExtremeSolid& cube, const TowerSetup& setup) { return Tower(response, cube, setup).run(); }

double leastTiltStiffness(int cubes) { return cubes * cubes / (2.4048 * 2.4048); }

double tiltStiffness(const ExtremeSolid& cube, double volume, bool onPlain)
{
	const double edge = ist::bounds(cube.mesh).longestSide();
	const ExtremeSolid plain{cube.mesh, nullptr};
	ist::QueryWorkspace workspace;
	ist::Pose X_AB;
	X_AB.translation.y = modelSinkage(cube, onPlain ? &plain : &cube, 1, volume) - edge;
	const ist::BoxField box(0.5 * ist::bounds(cube.mesh).size());
	const ist::OverlapIntegrals sums = onPlain ? ist::queryField(*cube.tree, box, X_AB, workspace).total
											   : ist::queryOverlap(*cube.tree, *cube.tree, X_AB, workspace).total;
	const ist::SymmetricMatrix6 K = ist::pressureStiffness(sums, {1, 0.5, 0.5});
	// The stiffness about z through the contact, half an edge below A's origin. A rotation there moves the origin by -half an edge along
	// x.
	const double lever = edge / 2;
	return (K(5, 5) - 2 * lever * K(0, 5) + lever * lever * K(0, 0)) / (volume * edge);
}
}  // namespace scenes
