// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ProbePath.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kClearance = 0.010;  // height above contact, before and after a touch [m]

class PathWriter
{
public:
	PathWriter(const MeshDistance& surface, const RodProbe& probe) : m_surface(surface), m_probe(probe), m_box(bounds(surface.mesh())) {}

	double travelHeight() const { return m_box.upper.y + m_probe.radius + 2 * kClearance; }

	/// Largest height at which the rod touches the surface when it descends at (x, z), or the bottom of the box.
	double contactHeight(double x, double z, double yaw) const
	{
		double y = travelHeight();
		while (y > m_box.lower.y)
		{
			const double gap = clearance({x, y, z}, yaw);
			if (gap < 1e-6) break;
			y -= gap;  // the distance is 1-Lipschitz, so this step never goes too far
		}
		return std::max(y, m_box.lower.y);
	}

	void moveTo(const Vec3& position, double seconds)
	{
		m_time += m_path.frames.empty() ? 0 : seconds;
		m_path.frames.push_back({m_time, {rotationMatrix(quaternionFromRotationVector({0, m_yaw, 0})), position}});
	}

	/// Moves the rod to `offset` above the height where it touches.
	void moveAbove(double x, double z, double offset, double seconds) { moveTo({x, contactHeight(x, z, m_yaw) + offset, z}, seconds); }

	void travelTo(double x, double z)
	{
		if (!m_path.frames.empty()) moveTo(withHeight(m_path.frames.back().pose.translation, travelHeight()), 0.4);
		moveTo({x, travelHeight(), z}, 0.5);
		moveAbove(x, z, kClearance, 0.5);
	}

	void turnTo(double yaw, double x, double z, double offset, double seconds)
	{
		const int steps = 12;
		const double from = m_yaw;
		for (int i = 1; i <= steps; ++i)
		{
			m_yaw = from + (yaw - from) * i / steps;
			moveAbove(x, z, offset, seconds / steps);
		}
	}

	void beginPhase(const char* name, bool touches)
	{
		endPhase();
		m_path.phases.push_back({name, m_time, m_time, touches});
	}
	void endPhase()
	{
		if (!m_path.phases.empty()) m_path.phases.back().end = m_time;
	}

	ProbePath finish()
	{
		endPhase();
		m_path.duration = m_time;
		return std::move(m_path);
	}
	const Box& box() const { return m_box; }

private:
	static Vec3 withHeight(Vec3 p, double y) { return {p.x, y, p.z}; }

	double clearance(const Vec3& center, double yaw) const
	{
		const Vec3 axis{std::sin(yaw), 0, std::cos(yaw)};
		const int samples = 9;
		double gap = 1e300;
		for (int i = 0; i < samples; ++i)
		{
			const double s = m_probe.halfLength * (2.0 * i / (samples - 1) - 1);
			gap = std::min(gap, m_surface.signedDistance(center + s * axis) - m_probe.radius);
		}
		return gap;
	}

	const MeshDistance& m_surface;
	RodProbe m_probe;
	Box m_box;
	ProbePath m_path;
	double m_time = 0, m_yaw = 0;
};

/// Points from the highest vertex downwards: at each height, the centre of the vertices near the centre above.
std::vector<Vec3> highestTip(const Mesh& mesh, double length, int count)
{
	Vec3 middle{0, -1e300, 0};
	for (const Vec3& p : mesh.vertices)
		if (p.y > middle.y) middle = p;
	const double top = middle.y, near = 0.6 * length;
	std::vector<Vec3> line;
	for (int i = 0; i < count; ++i)
	{
		const double height = top - 0.05 * length - 0.95 * length * i / (count - 1);
		Vec3 sum;
		int found = 0;
		for (const Vec3& p : mesh.vertices)
		{
			if (std::fabs(p.y - height) > 0.08 * length || std::hypot(p.x - middle.x, p.z - middle.z) > near) continue;
			sum += p;
			++found;
		}
		if (found > 0) middle = sum / found;
		line.push_back(middle);
	}
	return line;
}

void writeBack(PathWriter& path, double z, double press)
{
	const Box& box = path.box();
	const auto along = [&](double s) { return box.lower.x + s * box.size().x; };
	const double from = 0.64, to = 0.82;
	path.beginPhase("approach", false);
	path.travelTo(along(from), z);
	path.moveAbove(along(from), z, -press, 0.7);
	path.beginPhase("press", true);
	path.moveAbove(along(from), z, -press, 0.7);
	path.beginPhase("slide over the back", true);
	const int steps = 24;
	for (int i = 1; i <= steps; ++i) path.moveAbove(along(from + (to - from) * i / steps), z, -press, 1.6 / steps);
}

void writeEar(PathWriter& path, const Mesh& mesh, double press)
{
	const std::vector<Vec3> ear = highestTip(mesh, 0.2 * path.box().size().y, 16);
	path.beginPhase("cross to the ear", false);
	path.travelTo(ear[0].x, ear[0].z);
	path.moveAbove(ear[0].x, ear[0].z, -press, 0.6);
	path.beginPhase("slide along the ear", true);
	for (const Vec3& p : ear) path.moveAbove(p.x, p.z, -press, 1.6 / static_cast<double>(ear.size()));
}

void writeTurn(PathWriter& path, double z, double press)
{
	const double x = path.box().lower.x + 0.7 * path.box().size().x;
	path.beginPhase("cross to the back", false);
	path.travelTo(x, z);
	path.moveAbove(x, z, -press, 0.7);
	path.beginPhase("turn", true);
	path.turnTo(0.7, x, z, -press, 0.8);
	path.turnTo(-0.7, x, z, -press, 1.6);
	path.beginPhase("let go", false);
	path.moveAbove(x, z, 2 * kClearance, 0.5);
	path.moveAbove(x, z, 2 * kClearance, 0.3);
}
}  // namespace

ProbePath makeProbePath(const MeshDistance& surface, const RodProbe& probe, const ProbePress& press)
{
	PathWriter path(surface, probe);
	const double z = massProperties(surface.mesh()).centerOfMass.z;
	writeBack(path, z, press.back);
	writeEar(path, surface.mesh(), press.ear);
	writeTurn(path, z, press.back);
	return path.finish();
}
}  // namespace scenes
