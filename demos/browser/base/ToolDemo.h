// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/WorldDemo.h"

namespace browser
{
/// A demo in which a hand holds a tool by a virtual coupling and leads it along a path, until the user takes it.
class ToolDemo : public WorldDemo
{
public:
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override;
	bool grabTool() override;
	void release() override;

protected:
	/// Once, in `build`. The tool has no weight.
	/// `frequency`: root of the hand's stiffness over the tool's mass [rad/s].
	void holdTool(btRigidBody* tool, double frequency);
	btRigidBody* tool() const { return m_tool; }
	/// Where the hand wants the tool's principal frame at a time [s], World.
	virtual ist::Pose path(double time) const = 0;
	void beforeStep(double h) override;
	/// Of the hand on the tool in the last step, World.
	const ist::Wrench& handWrench() const { return m_wrench; }
	/// What is left of the balance of the hand's and the contacts' forces on the tool, over the hand's; 0 at rest (Newton).
	double imbalance() const;

private:
	btRigidBody* m_tool = nullptr;
	HandPull m_leading;
	ist::Wrench m_wrench;
	bool m_taken = false;
};

/// The place at a time on straight lines between points, each given with the time at which it is reached; at rest in each of them.
ist::Vec3 along(const std::vector<std::pair<double, ist::Vec3>>& points, double time);
}  // namespace browser
