// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"
#include "demos/browser/render/Matrix4.h"

#include <optional>

namespace browser
{
/// Turns about a target, y up.
class Camera
{
public:
	static constexpr double kVerticalAngle = 0.6;  ///< between lower and upper edge of the picture [rad]
	/// Width over height from which on that is so. Narrower pictures see as much from left to right, and more above and below.
	static constexpr double kFullAspect = 1.4;

	void set(const Viewpoint& view);
	const Viewpoint& viewpoint() const { return m_view; }
	/// Shares of the picture's height that the mouse went, right and down.
	void turn(double right, double down);
	void pan(double right, double down, double aspect);
	/// Nearer for positive.
	void zoom(double notches);

	ist::Vec3 eye() const;
	/// Right, up, and back towards the eye; unit length, World.
	ist::Mat3 axes() const;
	Matrix4 view() const;
	Matrix4 projection(double aspect) const;
	double nearest() const { return 0.02 * m_view.distance; }
	double farthest() const { return 40 * m_view.distance; }

	/// Direction of the ray through a point of the picture, (0, 0) its upper left corner and (1, 1) its lower right one. Unit length.
	ist::Vec3 ray(double x, double y, double aspect) const;
	/// Where a point of the World is seen, in the same measure; nothing behind the eye.
	std::optional<std::array<double, 2>> project(const ist::Vec3& point, double aspect) const;
	/// Height of the picture at a distance from the eye [m].
	double heightAt(double distance, double aspect) const;

private:
	Viewpoint m_view;
};
}  // namespace browser
