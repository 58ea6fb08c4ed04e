// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Coupling/VirtualCoupling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

using namespace devicebridge;

namespace
{
constexpr double kInf = std::numeric_limits<double>::infinity();

CouplingGains gains() { return {1000, 2, 5, 0.01, 100, 10}; }

ist::Mat3 turn(const ist::Vec3& v) { return rotationMatrix(ist::quaternionFromRotationVector(v)); }
}  // namespace

TEST(VirtualCoupling, SpringAndDamperPullTheToolToTheHand)
{
	const ist::Pose hand{turn({0.3, -0.2, 0.5}), {1000.01, 2, 3}};
	ToolState tool{{turn({0.3, -0.2, 0.5}), {1000, 2, 3}}, {{0, 0.1, 0}, {}}};
	const auto w = couplingOnTool(gains(), hand, {{0, 0.3, 0}, {}}, tool, kInf, kInf, 0);
	EXPECT_NEAR(w.force.x, 10, 1e-8);
	EXPECT_NEAR(w.force.y, 1, 1e-9);
	EXPECT_NEAR(norm(w.torque), 0, 1e-12);
}

TEST(VirtualCoupling, TorqueIsTheRotationVectorInWorld)
{
	const ist::Mat3 base = turn({0.7, 0.1, -0.4});
	const ist::Vec3 by{0.05, -0.3, 0.2};
	const ToolState tool{{base, {}}, {}};
	const auto w = couplingOnTool(gains(), {turn(by) * base, {}}, {}, tool, kInf, kInf, 0);
	EXPECT_NEAR(distance(w.torque, 2.0 * by), 0, 1e-12);
}

TEST(VirtualCoupling, SaturatesKeepingDirection)
{
	const ToolState tool;
	const auto w = couplingOnTool(gains(), {turn({0, 0, 3}), {3, 4, 0}}, {}, tool, kInf, kInf, 0);
	EXPECT_NEAR(w.force.x, 60, 1e-9);
	EXPECT_NEAR(w.force.y, 80, 1e-9);
	EXPECT_NEAR(w.torque.z, 6, 1e-9);
}

TEST(VirtualCoupling, SolvesTheImplicitStep)
{
	const double m = 0.1, h = 1e-3, v = 0.4, x = 0.02;
	const CouplingGains g = gains();
	ToolState tool;
	tool.twist.linear.x = v;
	const double f = couplingOnTool(g, {{}, {x, 0, 0}}, {{0.1, 0, 0}, {}}, tool, m, kInf, h).force.x;
	const double after = v + h * f / m;
	EXPECT_NEAR(f, g.stiffness * (x - h * after) + g.damping * (0.1 - after), 1e-10);
}

TEST(VirtualCoupling, StaysBoundedWhereTheExplicitLawDiverges)
{
	const double h = 1e-3;
	const CouplingGains stiff{1e7, 0, 0, 0, kInf, kInf};
	for (const bool implicit : {true, false})
	{
		ToolState tool;
		tool.X_WT.translation.x = 0.01;
		for (int i = 0; i < 1000; ++i)
		{
			const double mass = 0.05;
			const double used = implicit ? mass : kInf;
			const auto w = couplingOnTool(stiff, {}, {}, tool, used, kInf, implicit ? h : 0);
			tool.twist.linear += w.force * (h / mass);
			tool.X_WT.translation += tool.twist.linear * h;
		}
		const double reached = std::fabs(tool.X_WT.translation.x);
		if (implicit) EXPECT_LT(reached, 1e-3);
		else EXPECT_FALSE(reached < 1e6);
	}
}

TEST(VirtualCoupling, PassiveGainsRespectTheDevice)
{
	const auto profile = simulatedProfile("touchx").value();
	const auto g = passiveGains(profile.info, profile.damping, profile.angularDamping, 1e-3);
	EXPECT_NEAR(g.stiffness, 1000, 1e-9);
	EXPECT_EQ(g.angularStiffness, 0);
	EXPECT_NEAR(passiveGains(profile.info, 0.1, 0, 1e-3).stiffness, 200, 1e-9);
}
