// SPDX-License-Identifier: Zlib
// The real SDL with a virtual controller behind it.
#include <SDL2/SDL.h>

#include <atomic>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"

using namespace devicebridge;

namespace
{
class VirtualController
{
public:
	VirtualController()
	{
		SDL_SetMainReady();
		SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
		EXPECT_EQ(SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER), 0) << SDL_GetError();
		SDL_VirtualJoystickDesc description{};
		description.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
		description.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
		description.naxes = SDL_CONTROLLER_AXIS_MAX;
		description.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
		description.axis_mask = (1U << SDL_CONTROLLER_AXIS_MAX) - 1;
		description.button_mask = (1U << SDL_CONTROLLER_BUTTON_MAX) - 1;
		description.name = "test pad";
		description.userdata = this;
		description.Update = [](void* self) { static_cast<VirtualController*>(self)->update(); };
		description.Rumble = [](void* self, Uint16 low, Uint16 high) {
			static_cast<VirtualController*>(self)->low = low;
			static_cast<VirtualController*>(self)->high = high;
			return 0;
		};
		m_index = SDL_JoystickAttachVirtualEx(&description);
		EXPECT_GE(m_index, 0) << SDL_GetError();
		m_joystick = SDL_JoystickOpen(m_index);
	}
	~VirtualController()
	{
		if (m_joystick) SDL_JoystickClose(m_joystick);
		unplug();
		SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
	}
	void unplug()
	{
		if (m_index >= 0) SDL_JoystickDetachVirtual(m_index);
		m_index = -1;
	}

	std::atomic<int> x{0}, y{0}, z{0}, low{-1}, high{-1};
	std::atomic<bool> button{false};

private:
	void update()
	{
		SDL_JoystickSetVirtualAxis(m_joystick, SDL_CONTROLLER_AXIS_LEFTX, static_cast<Sint16>(x));
		SDL_JoystickSetVirtualAxis(m_joystick, SDL_CONTROLLER_AXIS_LEFTY, static_cast<Sint16>(y));
		SDL_JoystickSetVirtualAxis(m_joystick, SDL_CONTROLLER_AXIS_RIGHTY, static_cast<Sint16>(z));
		SDL_JoystickSetVirtualButton(m_joystick, SDL_CONTROLLER_BUTTON_B, button);
	}

	int m_index = -1;
	SDL_Joystick* m_joystick = nullptr;
};
}  // namespace

TEST(Rumble, SticksMoveTheHandle)
{
	VirtualController pad;
	auto device = DeviceRegistry().open("rumble:0?reach=0.1");
	ASSERT_TRUE(device) << device.error().message;
	EXPECT_EQ(device.value()->info().model, "test pad");
	EXPECT_EQ(device.value()->info().peakForce, 1);
	RealClock clock;
	DeviceState s;
	const int rows[][3] = {{32767, 0, 0}, {-32768, 0, 0}, {0, 32767, 0}, {0, 0, 32767}, {-8000, 4000, 12345}};
	for (const auto& row : rows)
	{
		pad.x = row[0], pad.y = row[1], pad.z = row[2];
		pad.button = row[2] != 0;
		const ist::Vec3 wanted{0.1 * row[0] / 32767.0, -0.1 * row[1] / 32767.0, 0.1 * row[2] / 32767.0};
		EXPECT_TRUE(within([&] {
			EXPECT_EQ(device.value()->read(clock.now(), s), DeviceStatus::Ok);
			return distance(s.X_WH.translation, wanted) < 1e-5 && s.buttons == (row[2] ? 1U << SDL_CONTROLLER_BUTTON_B : 0);
		}));
	}
	EXPECT_TRUE(s.velocityEstimated);
}

TEST(Rumble, ForceAndTorqueDriveTheMotors)
{
	VirtualController pad;
	auto device = DeviceRegistry().open("rumble:?full_force=4&full_torque=0.2");
	ASSERT_TRUE(device) << device.error().message;
	RealClock clock;
	DeviceCommand command;
	command.wrench = {{0, -1.2, 1.6}, {0.05, 0, 0}};  // half and a quarter of full force and torque
	EXPECT_TRUE(within([&] {
		DeviceState s;
		device.value()->read(clock.now(), s);
		command.computedAt = clock.now();
		command.expiresAt = command.computedAt + 300'000'000;
		device.value()->write(command);
		return pad.low == 32768 && pad.high == 16384;
	}));
	EXPECT_TRUE(within([&] { return pad.low == 0 && pad.high == 0; }));  // the command has expired
}

TEST(Rumble, AnUnpluggedControllerIsExplained)
{
	VirtualController pad;
	auto device = DeviceRegistry().open("rumble:0");
	ASSERT_TRUE(device) << device.error().message;
	DriverRun run(*device.value());
	EXPECT_TRUE(run.until([&] { return pad.low > 0; }));
	run.expectLossIsSafe(*device.value(), [&] { pad.unplug(); });
	EXPECT_NE(device.value()->complaint().find("unplugged"), std::string::npos);
}

TEST(Rumble, WithoutAControllerItSaysSo)
{
	const DeviceRegistry registry;
	for (const auto& [uri, word] : {std::pair<const char*, const char*>{"rumble:7", "no rumble:7"}, {"rumble:x", "numbered from 0"},
			 {"rumble:0?reach=far", "reach=far"}})
	{
		const auto device = registry.open(uri);
		ASSERT_FALSE(device) << uri;
		EXPECT_NE(device.error().message.find(word), std::string::npos) << device.error().message;
	}
}
