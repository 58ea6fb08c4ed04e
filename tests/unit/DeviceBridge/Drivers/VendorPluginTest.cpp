// SPDX-License-Identifier: Zlib
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Platform/DynamicLibrary.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"
#include "tests/unit/DeviceBridge/vendors/MockHandle.h"

using namespace devicebridge;

namespace
{
#if defined(_WIN32)
#define MOCK(name) "mock_" name ".dll"
#define SHIPPED(posix, windows) windows
#define FOLDERS(first, second) first ";" second
#else
#define MOCK(name) "libmock_" name ".so"
#define SHIPPED(posix, windows) posix
#define FOLDERS(first, second) first ":" second
#endif

/// A library in which a test finds what belongs to the mock.
DynamicLibrary loaded(const std::string& file)
{
	DynamicLibrary library;
	EXPECT_TRUE(library.load(file, DynamicLibrary::Symbols::Own)) << library.why();
	return library;
}

struct Vendor
{
	const char *name, *variable, *shipped, *file, *uri, *wrongUri, *error;
	double peakForce, peakTorque, stiffness;
	bool hasSwitches, hasDeadMan;
};
void PrintTo(const Vendor& vendor, std::ostream* out) { *out << vendor.name; }

const Vendor kVendors[] = {{"chai3d", nullptr, nullptr, TEST_VENDOR_FOLDER "/" MOCK("chai3d"), "chai3d:0", "chai3d:1", "CHAI3D has lost",
							   12, 0.1, 5000, false, false},
	{"dhd", "DEVICEBRIDGE_DHD_LIBRARY", SHIPPED("libdhd.so", "dhd64.dll"), TEST_VENDOR_FOLDER "/" MOCK("dhd"), "dhd:0", "dhd:1",
		"communication error", 12, 0.2, 4000, true, false},
	{"hd", "DEVICEBRIDGE_HD_LIBRARY", SHIPPED("libHD.so", "HD.dll"), TEST_VENDOR_FOLDER "/" MOCK("hd"), "hd:Right Device", "hd:Left Device",
		"device communication error", 3.3, 0, 500, true, false},
	{"virtuose", "DEVICEBRIDGE_VIRTUOSE_LIBRARY", SHIPPED("virtuoseAPI.so", "virtuoseAPI.dll"), TEST_VENDOR_FOLDER "/" MOCK("virtuose"),
		"virtuose:arm.local?peak_force=30&peak_torque=3", "virtuose:nobody", "communication failure", 30, 3, 700, true, true},
	{"vrpn", nullptr, nullptr, TEST_VENDOR_FOLDER "/" MOCK("vrpn"), "vrpn://lab:3883/Tool0?peak_force=5&sensor=2&stiffness=300",
		"vrpn://lab:3883/Tool9?sensor=2", "closed the connection", 5, 0, 300, false, false}};

std::vector<Vendor> vendorsWithSwitches()
{
	std::vector<Vendor> some;
	for (const Vendor& vendor : kVendors)
		if (vendor.hasSwitches) some.push_back(vendor);
	return some;
}

// Plug-ins built against the mocks come before those built against the real library.
constexpr const char* kPlugins = FOLDERS(TEST_VENDOR_FOLDER, PLUGIN_FOLDER);

class VendorPlugin : public testing::TestWithParam<Vendor>
{
protected:
	void SetUp() override
	{
		setenv("DEVICEBRIDGE_PLUGIN_PATH", kPlugins, 1);
		if (GetParam().variable) setenv(GetParam().variable, GetParam().file, 1);
		const DynamicLibrary library = loaded(GetParam().file);
		ASSERT_TRUE(library.isLoaded());
		m_mock = library.find<MockHandle*()>("mockHandle")();
		change([](MockHandle& m) {
			m.present = m.calibrated = m.motorsOn = m.handPresent = true, m.misuse = 0;
			// A handle that reports a velocity and repeats its pose counts as frozen after 10 ms.
			std::fill_n(m.linear, 3, 0), std::fill_n(m.angular, 3, 0);
		});
	}
	void TearDown() override
	{
		unsetenv("DEVICEBRIDGE_PLUGIN_PATH");
		if (GetParam().variable) unsetenv(GetParam().variable);
	}
	template <class Change> void change(Change&& c)
	{
		const std::lock_guard<std::mutex> lock(m_mock->mutex);
		c(*m_mock);
	}
	template <class Look> auto look(Look&& l)
	{
		const std::lock_guard<std::mutex> lock(m_mock->mutex);
		return l(*m_mock);
	}
	std::unique_ptr<Device> opened()
	{
		auto device = DeviceRegistry().open(GetParam().uri);
		if (device) return std::move(device).value();
		ADD_FAILURE() << device.error().message;
		return nullptr;
	}

private:
	MockHandle* m_mock = nullptr;
};
}  // namespace

TEST_P(VendorPlugin, TellsWhatTheDeviceIs)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	const DeviceInfo& info = device->info();
	EXPECT_EQ(info.uri, GetParam().uri);
	EXPECT_NEAR(info.peakForce, GetParam().peakForce, 1e-12);
	EXPECT_NEAR(info.peakTorque, GetParam().peakTorque, 1e-12);
	EXPECT_NEAR(info.maxStiffness, GetParam().stiffness, 1e-9);
	EXPECT_TRUE(info.sensed & kRotation);
	EXPECT_EQ((info.actuated & kRotation) != 0, GetParam().peakTorque > 0);
	EXPECT_EQ(info.handedness, GetParam().name == std::string("dhd") ? Handedness::Left : Handedness::Either);
	EXPECT_FALSE(info.model.empty() || info.maker.empty() || info.source.empty());
}

TEST_P(VendorPlugin, IsFeltByTheRecipeWithNothingSet)
{
	const std::string name = GetParam().name, uri = GetParam().uri;
	auto opened = DeviceRegistry().open(name == "vrpn" ? uri.substr(0, uri.find('?')) + "?sensor=2" : uri.substr(0, uri.find('?')));
	ASSERT_TRUE(opened) << opened.error().message;
	Device& device = *opened.value();
	const DeviceInfo& info = device.info();
	if (name == "vrpn")  // it reports neither limits nor a model, and nothing is assumed
	{
		EXPECT_EQ(info.actuated + info.assumed, 0U);
		EXPECT_EQ(info.peakForce + info.maxStiffness + info.damping, 0);
		return;
	}
	EXPECT_TRUE(info.assumed & kAssumedDamping) << "of none of them it is known";
	EXPECT_NE(info.source.find("assumed"), std::string::npos) << info.source;
	EXPECT_EQ((info.assumed & kAssumedMaxStiffness) != 0, name != "hd") << "libHD tells it";
	for (const double damping : {info.damping, 2.5, 0.0})
	{
		DriverRun run(device);
		EXPECT_GT(run.forceByRecipe(device, damping), 0);
		EXPECT_TRUE(run.until([&] { return look([](MockHandle& m) { return std::abs(m.force[2]) > 0; }); }));
	}
}

TEST_P(VendorPlugin, LimitsThatTheDeviceDoesNotTellSaySo)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	const DeviceInfo& info = device->info();
	const std::string name = GetParam().name;
	const unsigned peak = info.assumed & kAssumedPeakForce;
	EXPECT_EQ(peak != 0, name == "chai3d" || name == "dhd") << "the others are told, or given with the address";
	EXPECT_EQ(info.profile, name == "dhd" ? "sigma7" : name == "hd" ? "touch" : name == "chai3d" ? "omega7" : "");
	EXPECT_TRUE(info.continuousForce == 0 || info.continuousForce < info.peakForce);
}

TEST_P(VendorPlugin, PosesArriveInMetresAndRightHanded)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	std::mt19937_64 random(7);
	std::normal_distribution<double> normal;
	RealClock clock;
	for (int round = 0; round < 20; ++round)
	{
		const ist::Vec3 p{0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)},
			v{normal(random), normal(random), normal(random)}, w{normal(random), normal(random), normal(random)};
		const ist::Quaternion q = ist::quaternionFromRotationVector(ist::Vec3{normal(random), normal(random), normal(random)});
		change([&](MockHandle& m) {
			const double vectors[3][3] = {{p.x, p.y, p.z}, {v.x, v.y, v.z}, {w.x, w.y, w.z}};
			for (int i = 0; i < 3; ++i) m.position[i] = vectors[0][i], m.linear[i] = vectors[1][i], m.angular[i] = vectors[2][i];
			m.quaternion[0] = q.x, m.quaternion[1] = q.y, m.quaternion[2] = q.z, m.quaternion[3] = q.w;
			m.buttons = static_cast<unsigned>(round % 8);
		});
		DeviceState s;
		EXPECT_TRUE(within(
			[&] {
				EXPECT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
				const ist::Vec3 turn = rotationVector(ist::quaternion(s.X_WH.rotation * transpose(rotationMatrix(q))));
				return distance(s.X_WH.translation, p) < 1e-6 && distance(s.twist.linear, v) < 1e-6 &&
					distance(s.twist.angular, w) < 1e-6 && norm(turn) < 1e-6 && s.buttons == static_cast<unsigned>(round % 8);
			},
			5000));
	}
	EXPECT_EQ(look([](MockHandle& m) { return m.misuse; }), 0);
}

TEST_P(VendorPlugin, TheWrenchArrivesAndEndsWithItsCommand)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	RealClock clock;
	DeviceCommand command;
	command.wrench = {{0.5, -1, 2}, {0.01, 0.02, -0.03}};
	const auto differs = [&](const ist::Wrench& wanted) {
		return look([&](MockHandle& m) {
			const ist::Vec3 f{m.force[0], m.force[1], m.force[2]}, t{m.torque[0], m.torque[1], m.torque[2]};
			return std::max(distance(f, wanted.force), GetParam().peakTorque > 0 ? distance(t, wanted.torque) : 0);
		});
	};
	EXPECT_TRUE(within([&] {
		command.computedAt = clock.now();
		command.expiresAt = command.computedAt + 100'000'000;
		EXPECT_EQ(device->write(command), DeviceStatus::Ok);
		return differs(command.wrench) < 1e-6;
	}));
	EXPECT_TRUE(within([&] { return differs({}) == 0; }));
}

/// The vendors that report whether the motors are on; CHAI3D and VRPN do not.
class VendorSwitches : public VendorPlugin
{};
TEST_P(VendorSwitches, HoldTheForceBack)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	DriverRun run(*device);
	ASSERT_TRUE(run.until([&] { return run.force() > 0; }));
	change([](MockHandle& m) { m.motorsOn = false; });
	EXPECT_TRUE(run.until([&] { return run.force() == 0; }));
	change([](MockHandle& m) { m.motorsOn = true; });
	EXPECT_TRUE(run.until([&] { return run.force() > 0; }));
	if (!GetParam().hasDeadMan) return;
	change([](MockHandle& m) { m.handPresent = false; });
	EXPECT_TRUE(run.until([&] { return run.force() == 0; }));
}

TEST_P(VendorPlugin, APulledCableEndsTheForceAndIsExplained)
{
	const auto device = opened();
	ASSERT_TRUE(device);
	DriverRun run(*device);
	run.expectLossIsSafe(*device, [&] { change([](MockHandle& m) { m.present = false; }); });
	EXPECT_NE(device->complaint().find(GetParam().error), std::string::npos) << device->complaint();
	EXPECT_EQ(look([](MockHandle& m) { return m.open; }), 0);
	EXPECT_EQ(look([](MockHandle& m) { return m.force[2]; }), 0);
	change([](MockHandle& m) { m.present = true; });
	EXPECT_EQ(device->open(), DeviceStatus::Ok);
}

TEST_P(VendorPlugin, WhatIsMissingIsSaid)
{
	const DeviceRegistry registry;
	const auto wrong = registry.open(GetParam().wrongUri);
	ASSERT_FALSE(wrong);
	EXPECT_GT(wrong.error().message.size(), 30U) << wrong.error().message;
	if (!GetParam().variable) return;
	setenv(GetParam().variable, "/nowhere/libnothing.so", 1);
	const auto device = registry.open(GetParam().uri);
	ASSERT_FALSE(device);
	EXPECT_NE(device.error().message.find(GetParam().variable), std::string::npos) << device.error().message;
	bool listed = false;
	for (const DriverReport& driver : registry.drivers())
		listed |= driver.scheme == GetParam().name && driver.missing.find("/nowhere/libnothing.so") != std::string::npos;
	EXPECT_TRUE(listed);
	// The file is another library.
	setenv(GetParam().variable, TEST_VENDOR_FOLDER "/" MOCK("empty"), 1);
	const auto other = registry.open(GetParam().uri);
	ASSERT_FALSE(other);
	EXPECT_NE(other.error().message.find("lacks the function"), std::string::npos) << other.error().message;
}

// Tests with the vendor's own file instead of the mock: its folder on the loader's path is sufficient.
TEST_P(VendorPlugin, LooksForTheVendorsOwnFile)
{
	if (!GetParam().variable) return;
	unsetenv(GetParam().variable);
	int listed = 0;
	for (const DriverReport& driver : DeviceRegistry().drivers())
	{
		if (driver.scheme != GetParam().name) continue;
		++listed;
		// An empty text means that it is installed here.
		EXPECT_TRUE(driver.missing.empty() || driver.missing.find(GetParam().shipped) != std::string::npos) << driver.missing;
	}
	EXPECT_EQ(listed, 1);
}

INSTANTIATE_TEST_SUITE_P(Mocks, VendorPlugin, testing::ValuesIn(kVendors), [](const auto& info) { return std::string(info.param.name); });
INSTANTIATE_TEST_SUITE_P(
	Mocks, VendorSwitches, testing::ValuesIn(vendorsWithSwitches()), [](const auto& info) { return std::string(info.param.name); });

TEST(VrpnPlugin, AVelocityThatTheServerDoesNotTellComesFromThePositions)
{
	setenv("DEVICEBRIDGE_PLUGIN_PATH", kPlugins, 1);
	const DynamicLibrary library = loaded(TEST_VENDOR_FOLDER "/" MOCK("vrpn"));
	ASSERT_TRUE(library.isLoaded());
	MockHandle& mock = *library.find<MockHandle*()>("mockHandle")();
	{
		const std::lock_guard<std::mutex> lock(mock.mutex);
		mock.present = true, mock.tellsVelocity = false;
		for (int i = 0; i < 3; ++i) mock.linear[i] = 0.01 * (i + 1);
	}
	auto device = DeviceRegistry().open("vrpn:Tool0@tcp://lab:3883?sensor=2&rate=100");
	ASSERT_TRUE(device) << device.error().message;
	EXPECT_EQ(device.value()->info().nominalRate, 100);
	EXPECT_EQ(device.value()->info().actuated, 0U);
	RealClock clock;
	DeviceState s;
	// Times have a resolution of a microsecond, and samples are a millisecond apart.
	EXPECT_TRUE(within(
		[&] {
			EXPECT_EQ(device.value()->read(clock.now(), s), DeviceStatus::Ok);
			return s.velocityEstimated && distance(s.twist.linear, {0.01, 0.02, 0.03}) < 3e-4;
		},
		5000));
	const std::lock_guard<std::mutex> lock(mock.mutex);
	mock.tellsVelocity = true;
}

TEST(VrpnPlugin, AReportThatIsNotFiniteIsPassedOver)
{
	setenv("DEVICEBRIDGE_PLUGIN_PATH", kPlugins, 1);
	const DynamicLibrary library = loaded(TEST_VENDOR_FOLDER "/" MOCK("vrpn"));
	ASSERT_TRUE(library.isLoaded());
	MockHandle& mock = *library.find<MockHandle*()>("mockHandle")();
	const auto change = [&](auto&& c) {
		const std::lock_guard<std::mutex> lock(mock.mutex);
		c();
	};
	change([&] { mock.present = true, mock.tellsVelocity = false; });
	auto device = DeviceRegistry().open("vrpn:Tool0@tcp://lab:3883?sensor=2&rate=100");
	ASSERT_TRUE(device) << device.error().message;
	RealClock clock;
	DeviceState s;
	const auto next = [&] {
		const std::uint64_t before = s.sequence;
		return within([&] { return device.value()->read(clock.now(), s) == DeviceStatus::Ok && s.sequence > before + 5; }, 5000);
	};
	ASSERT_TRUE(next());
	const double nothing = std::numeric_limits<double>::quiet_NaN();
	for (double* broken : {&mock.position[1], &mock.quaternion[0]})
	{
		const double good = *broken;
		change([&] { *broken = nothing; });
		std::this_thread::sleep_for(std::chrono::milliseconds(20));
		EXPECT_EQ(device.value()->read(clock.now(), s), DeviceStatus::Ok);
		change([&] { *broken = good; });
		ASSERT_TRUE(next());
		EXPECT_TRUE(ist::isRigid(s.X_WH));
		EXPECT_TRUE(ist::isFinite(s.twist));
	}
	change([&] { mock.tellsVelocity = true; });
}

TEST(VrpnPlugin, RefusesWhatIsNoneInASentence)
{
	setenv("DEVICEBRIDGE_PLUGIN_PATH", kPlugins, 1);
	const DeviceRegistry registry;
	for (const char* wrong : {"vrpn:", "vrpn://", "vrpn://lab:3883", "vrpn:///Tool0", "vrpn://lab:3883/",
			 "vrpn://lab:3883/Tool0?sensor=first", "vrpn://lab:3883/Tool0?color=red"})
	{
		const auto device = registry.open(wrong);
		ASSERT_FALSE(device) << wrong;
		EXPECT_GT(device.error().message.size(), 30U) << device.error().message;
	}
	const auto absent = registry.open("vrpn://nobody:3883/Tool0");
	ASSERT_FALSE(absent);
	EXPECT_NE(absent.error().message.find("no VRPN server answers"), std::string::npos) << absent.error().message;
}
