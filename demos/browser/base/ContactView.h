// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Force/ContactPoints.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"
#include "demos/browser/base/DemoWorld.h"

#include <map>
#include <set>

namespace browser
{
/// Draws the contacts of a world's bodies. It may repeat a query to obtain the pairs of leaves.
class ContactView
{
public:
	/// Adds everything that is chosen. A force of `arrowForce` [N] has an arrow of the length `arrowLength` [m].
	void draw(DemoWorld& world, const DrawChoice& choice, double arrowForce, double arrowLength, DrawList& list);

	/// Levels of the bodies' trees that answered in the last drawing.
	const std::set<int>& answering() const { return m_answering; }

private:
	void drawBodies(DemoWorld& world, const DrawChoice& choice, DrawList& list) const;
	bool drawContactSurface(const btISTContact& contact, const ist::OverlapResult& answer, DrawList& list);
	void drawLenses(const btISTContact& contact, DrawList& list);
	void drawLevels(const btISTContact& contact, const ist::LevelPair& trees, DrawList& list);
	void addKeys(const DrawChoice& choice, DrawList& list) const;
	void drawStock(const DemoWorld& world, const DrawChoice& choice, DrawList& list);
	void drawForces(const DemoWorld& world, const btISTContact& contact, DrawList& list);
	void drawForce(const ist::Vec3& at, const ist::Vec3& force, DrawList& list) const;
	/// Draws a moment. `lever` [m] is the distance at which a force has such a moment; a moment that is small beside the forces is not
	/// drawn.
	void drawMoment(const ist::Vec3& at, const ist::Vec3& moment, double lever, DrawList& list) const;

	ist::QueryWorkspace m_workspace;
	std::vector<ist::ContactPoint> m_points;
	std::set<std::pair<const void*, const void*>> m_drawnLevels;  // bodies and the trees that answer for them
	std::map<int, size_t> m_ballsOfLevel;
	std::set<int> m_answering;
	double m_strongest = 0;  // largest force in the picture [N]
	double m_arrowForce = 1, m_arrowLength = 1;
};

/// A force as text: "12.3 N".
std::string formatForce(double newton);
}  // namespace browser
