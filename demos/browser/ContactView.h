// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/OverlapQuery.h"
#include "demos/browser/DemoWorld.h"

namespace browser
{
/// Shows what the bodies of a world say to each other. Allocates its memory once; may ask a query again to have the pairs.
class ContactView
{
public:
	/// Adds everything that is chosen. `arrowForce`: force whose arrow is `arrowLength` long [N, m].
	void draw(DemoWorld& world, const DrawChoice& choice, double arrowForce, double arrowLength, DrawList& list);

private:
	void drawBodies(DemoWorld& world, const DrawChoice& choice, DrawList& list) const;
	void drawLenses(const btISTContact& contact, DrawList& list);
	void drawStock(const DemoWorld& world, const DrawChoice& choice, DrawList& list);
	void drawPatches(const DemoWorld& world, const btISTContact& contact, const DrawChoice& choice, DrawList& list);
	void drawForce(const ist::Vec3& at, const ist::Vec3& force, DrawList& list) const;

	ist::QueryWorkspace m_workspace;
	double m_strongest = 0;  // of all forces in the picture [N]
	double m_arrowForce = 1, m_arrowLength = 1;
};

/// A force in words: "12.3 N".
std::string formatForce(double newton);
}  // namespace browser
