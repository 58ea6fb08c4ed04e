// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ToolDemo.h"

#include <algorithm>

using namespace ist;

namespace browser
{
Vec3 along(const std::vector<std::pair<double, Vec3>>& points, double time)
{
	for (size_t i = 1; i < points.size(); ++i)
		if (time < points[i].first)
		{
			const double u = std::max(0.0, (time - points[i - 1].first) / (points[i].first - points[i - 1].first));
			return points[i - 1].second + u * u * (3 - 2 * u) * (points[i].second - points[i - 1].second);
		}
	return points.back().second;
}

void ToolDemo::holdTool(btRigidBody* tool, double frequency)
{
	if (!tool) return;
	m_tool = tool;
	m_taken = false;
	m_wrench = {};
	tool->setGravity(btVector3(0, 0, 0));
	m_leading.setFrequency(frequency);
	m_leading.grab(tool);
}

void ToolDemo::beforeStep(double h)
{
	if (!m_tool || isFelt()) return;
	// The user's hand replaces this one.
	if (m_taken && hand().body() == m_tool) return;
	if (!m_taken) m_leading.setTarget(path(time()));
	m_wrench = m_leading.pull(h);
}

double ToolDemo::imbalance() const
{
	const double pull = norm(m_wrench.force);
	return pull > 0 ? norm(m_wrench.force + world().contactForce(m_tool)) / pull : 0;
}

std::optional<double> ToolDemo::grab(const Vec3& from, const Vec3& direction)
{
	const auto met = WorldDemo::grab(from, direction);
	if (met && hand().body() == m_tool) m_taken = true;
	return met;
}

bool ToolDemo::grabTool()
{
	if (!m_tool || isFelt()) return false;
	if (!hand().holds()) hand().grab(m_tool);
	m_taken = m_taken || hand().body() == m_tool;
	return true;
}

void ToolDemo::release()
{
	if (hand().holds() && hand().body() == m_tool) m_leading.setTarget(hand().target());
	WorldDemo::release();
}

std::optional<Error> ToolDemo::feelWith(devicebridge::Device& device, double scale)
{
	if (!m_tool) return WorldDemo::feelWith(device, scale);
	return feel(device, *m_tool, scale);
}
}  // namespace browser
