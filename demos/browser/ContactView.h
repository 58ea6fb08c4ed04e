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
	void drawPatches(const DemoWorld& world, const btISTContact& contact, const DrawChoice& choice, double arrowForce, double arrowLength, DrawList& list);

	ist::QueryWorkspace m_workspace;
	double m_strongest = 0;  // of all patches in the picture [N]
};

/// A force in words: "12.3 N".
std::string formatForce(double newton);
}  // namespace browser
