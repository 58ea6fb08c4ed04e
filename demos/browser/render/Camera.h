// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/render/Matrix4.h"

#include <optional>

namespace browser
{
/// A camera that orbits a target; y points up.
class Camera
{
public:
	static constexpr double kVerticalAngle = 0.6;  ///< angle between the lower and the upper edge of the picture [rad]
	/// Aspect (width over height) from which on kVerticalAngle holds. Narrower pictures show the same width, and more above and below.
	static constexpr double kFullAspect = 1.4;

	void set(const Viewpoint& view);
	const Viewpoint& viewpoint() const { return m_view; }
	/// Orbits. The arguments are mouse motions to the right and down, as shares of the picture's height.
	void turn(double right, double down);
	void pan(double right, double down, double aspect);
	/// Moves nearer for positive `notches`.
	void zoom(double notches);

	ist::Vec3 eye() const;
	/// Axes to the right, up, and back towards the eye; unit length, World.
	ist::Mat3 axes() const;
	Matrix4 view() const;
	Matrix4 projection(double aspect) const;
	double nearest() const { return 0.02 * m_view.distance; }
	double farthest() const { return 40 * m_view.distance; }

	/// Direction of the ray through a point of the picture; unit length. (0, 0) is the upper left corner, (1, 1) the lower right one.
	ist::Vec3 ray(double x, double y, double aspect) const;
	/// Position in the picture of a point of World, in the same measure; nothing for a point behind the eye.
	std::optional<std::array<double, 2>> project(const ist::Vec3& point, double aspect) const;
	/// Height of the visible area at a distance from the eye [m].
	double heightAt(double distance, double aspect) const;

private:
	Viewpoint m_view;
};
}  // namespace browser
