// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include "BulletISTCollision/Core/Base/Pose.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <utility>

/// The surface of a mesh whose center of mass is the origin. `size`: number of cells, and of elements.
inline ist::BodySurface surfaceOf(const ist::Mesh& mesh, int64_t size)
{
	ist::BodySurfaceOptions options;
	options.cells = options.elements = size;
	ist::Result<ist::BodySurface> body = ist::buildBodySurface(ist::MeshDistance(mesh), options);
	EXPECT_TRUE(body) << body.error().message;
	EXPECT_EQ(body.value().validate(), "");
	return std::move(body).value();
}

/// `axis` has unit length.
inline ist::Mat3 turned(double angle, const ist::Vec3& axis) { return rotationMatrix(ist::quaternionFromRotationVector(angle * axis)); }

/// Turned at random, and moved by up to `size` along each axis.
inline ist::Pose randomPose(std::mt19937& random, double size)
{
	std::uniform_real_distribution<double> u(-1, 1);
	const ist::Vec3 axis = normalized(ist::Vec3{u(random), u(random), u(random)});
	return {turned(std::numbers::pi * u(random), axis), size * ist::Vec3{u(random), u(random), u(random)}};
}
