// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/WorldDemo.h"

namespace browser
{
/// A demo in which a hand holds a tool by a virtual coupling and moves it along a path, until the user grabs it.
class ToolDemo : public WorldDemo
{
public:
	std::optional<double> grab(const ist::Vec3& from, const ist::Vec3& direction) override;
	bool grabTool() override;
	void release() override;
	std::optional<ist::Error> feelWith(devicebridge::Device& device, double scale) override;

protected:
	/// Makes the hand hold the tool; call it once, in `build`. The tool's weight is switched off. `frequency` is the root of the hand's
	/// stiffness over the tool's mass [rad/s].
	void holdTool(btRigidBody* tool, double frequency);
	btRigidBody* tool() const { return m_tool; }
	const btRigidBody* sceneTool() const override { return m_tool; }
	/// Pose that the hand wants for the tool's principal frame at a time [s], World.
	virtual ist::Pose path(double time) const = 0;
	void beforeStep(double h) override;
	/// Wrench of the hand on the tool in the last step, World.
	const ist::Wrench& handWrench() const { return m_wrench; }
	/// Sum of the hand's and the contacts' forces on the tool, divided by the hand's force; 0 at rest (Newton).
	double imbalance() const;

private:
	btRigidBody* m_tool = nullptr;
	HandPull m_leading;
	ist::Wrench m_wrench;
	bool m_taken = false;
};

/// Position at a time on straight lines between points, each given with its time; the motion rests at each of them.
ist::Vec3 along(const std::vector<std::pair<double, ist::Vec3>>& points, double time);
}  // namespace browser
