// SPDX-License-Identifier: Zlib
#include "demos/browser/DeviceHand.h"

#include <gtest/gtest.h>

using namespace browser;
using devicebridge::DeviceStatus;

namespace
{
/// What the hand asked of the demo.
class Held : public BrowsableDemo
{
public:
	std::optional<ist::Error> prepare(const DemoOptions&) override { return std::nullopt; }
	std::optional<ist::Error> restart() override { return std::nullopt; }
	void step(double) override {}
	double duration() const override { return 1; }
	double time() const override { return 0; }
	void draw(const DrawChoice&, DrawList&) override {}
	Viewpoint viewpoint() const override { return {}; }
	std::vector<Figure> figures() const override { return {}; }
	bool grabTool() override { return true; }
	void drag(const ist::Vec3& shift, const ist::Vec3& turn) override { shifted += shift, turned += turn; }

	ist::Vec3 shifted, turned;
};

struct Scripted : devicebridge::Device
{
	devicebridge::DeviceInfo own;
	ist::Pose X;
	bool answers = true;
	const devicebridge::DeviceInfo& info() const noexcept override { return own; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, devicebridge::DeviceState& state) noexcept override
	{
		if (!answers) return DeviceStatus::Disconnected;
		state.X_WH = X;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const devicebridge::DeviceCommand&) noexcept override { return ADD_FAILURE() << "no force from here", DeviceStatus::Ok; }
};
}  // namespace

TEST(DeviceHand, MovesByWhatTheHandMovedFromWhereverItBegins)
{
	auto owned = std::make_unique<Scripted>();
	Scripted& device = *owned;
	DeviceHand hand(std::move(owned));
	Held demo;
	device.X.translation = {1000, -3, 2};
	EXPECT_FALSE(hand.update(demo, 2));
	EXPECT_EQ(norm(demo.shifted), 0);
	device.X.translation += {0.01, 0.02, -0.03};
	device.X.rotation = rotationMatrix(ist::quaternionFromRotationVector({0, 0.2, 0}));
	EXPECT_FALSE(hand.update(demo, 2));
	EXPECT_LT(norm(demo.shifted - ist::Vec3{0.02, 0.04, -0.06}), 1e-9);
	EXPECT_LT(norm(demo.turned - ist::Vec3{0, 0.2, 0}), 1e-9);
}

TEST(DeviceHand, SaysOnceThatItIsLostAndGoesOnWithoutALeap)
{
	auto owned = std::make_unique<Scripted>();
	Scripted& device = *owned;
	DeviceHand hand(std::move(owned));
	Held demo;
	EXPECT_FALSE(hand.update(demo, 1));
	device.answers = false;
	const auto lost = hand.update(demo, 1);
	ASSERT_TRUE(lost);
	EXPECT_NE(lost->message.find("does not answer"), std::string::npos);
	EXPECT_FALSE(hand.update(demo, 1));
	device.answers = true;
	device.X.translation = {5, 5, 5};
	EXPECT_FALSE(hand.update(demo, 1));
	EXPECT_EQ(norm(demo.shifted), 0);
}

TEST(DeviceHand, NamesADeviceThatIsNotThere)
{
	const auto missing = DeviceHand::open("nonsense:1");
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find("nonsense"), std::string::npos);
}
