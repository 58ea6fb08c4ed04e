// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Camera.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr double kSteepest = 1.55;
}  // namespace

void Camera::set(const Viewpoint& view)
{
	m_view = view;
	m_view.pitch = std::clamp(view.pitch, -kSteepest, kSteepest);
}

void Camera::turn(double right, double down)
{
	m_view.yaw -= kPi * right;
	m_view.pitch = std::clamp(m_view.pitch + kPi * down, -kSteepest, kSteepest);
}

void Camera::pan(double right, double down, double aspect)
{
	const Mat3 a = axes();
	m_view.target += heightAt(m_view.distance, aspect) * (-right * a.column(0) + down * a.column(1));
}

void Camera::zoom(double notches) { m_view.distance = std::clamp(m_view.distance * std::pow(0.88, notches), 1e-6, 1e6); }

Mat3 Camera::axes() const
{
	const double cy = std::cos(m_view.yaw), sy = std::sin(m_view.yaw), cp = std::cos(m_view.pitch), sp = std::sin(m_view.pitch);
	const Vec3 back{sy * cp, sp, cy * cp}, right{cy, 0, -sy}, up = cross(back, right);
	return {{{right.x, up.x, back.x}, {right.y, up.y, back.y}, {right.z, up.z, back.z}}};
}

Vec3 Camera::eye() const { return m_view.target + m_view.distance * axes().column(2); }

Matrix4 Camera::view() const { return matrixOf(inverse(Pose{axes(), eye()})); }

Matrix4 Camera::projection(double aspect) const
{
	return perspective(2 * std::atan(0.5 * heightAt(1, aspect)), aspect, nearest(), farthest());
}

double Camera::heightAt(double distance, double aspect) const
{
	return 2 * distance * std::tan(kVerticalAngle / 2) * std::max(1.0, kFullAspect / aspect);
}

Vec3 Camera::ray(double x, double y, double aspect) const
{
	const double h = heightAt(1, aspect);
	return normalized(axes() * Vec3{(x - 0.5) * h * aspect, (0.5 - y) * h, -1});
}

std::optional<std::array<double, 2>> Camera::project(const Vec3& point, double aspect) const
{
	const Vec3 p = transpose(axes()) * (point - eye());
	if (p.z >= -nearest()) return std::nullopt;
	const double h = heightAt(-p.z, aspect);
	return std::array<double, 2>{0.5 + p.x / (h * aspect), 0.5 - p.y / h};
}
}  // namespace browser
