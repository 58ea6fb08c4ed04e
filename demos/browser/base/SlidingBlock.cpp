// SPDX-License-Identifier: Zlib
#include "demos/browser/base/SlidingBlock.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/browser/base/DemoWorld.h"

#include <cmath>
#include <utility>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kSlope = 0.4, kFriction = 0.3, kSeconds = 0.5;
constexpr Vec3 kHalf{0.15, 0.03, 0.1};
const double kAcceleration = kGravity * (std::sin(kSlope) - kFriction * std::cos(kSlope));
}  // namespace

std::optional<Error> SlidingBlock::prepare(const DemoOptions& options)
{
	DemoOptions own = options;
	own.spheres = 0;
	return makeSolid(m_block, "block", makeBoxMesh(kHalf), 300, own);
}

double SlidingBlock::error(scenes::Response response, int rate) const
{
	// The slope is level, and gravity is inclined instead.
	DemoWorld world(response, {kGravity * std::sin(kSlope), -kGravity * std::cos(kSlope), 0});
	world.addPlane({0, 1, 0}, 0, 1);
	BodySetup setup;
	setup.mass = 2;
	setup.friction = kFriction;
	setup.X_WM.translation = {0, kHalf.y, 0};
	if (!world.add(m_block, std::move(setup))) return std::nan("");
	world.keepAwake(true);
	const int steps = int(std::lround(kSeconds * rate));
	for (int i = 0; i < steps; ++i) world.step(1.0 / rate);
	const double exact = 0.5 * kAcceleration * kSeconds * kSeconds;
	return std::fabs(world.bodies().front().X_WP().translation.x - exact) / (2 * kHalf.x);
}

double SlidingBlock::expectedError(int rate) { return 0.5 * kAcceleration * kSeconds / rate / (2 * kHalf.x); }
}  // namespace browser
