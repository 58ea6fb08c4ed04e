// SPDX-License-Identifier: Zlib
// Tests of the plug-in against the real VRPN over a socket: a server with a tracker, buttons and a force device. They are a separate file
// and program, because they link VRPN.
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vrpn_Button.h>
#include <vrpn_Connection.h>
#include <vrpn_ForceDevice.h>
#include <vrpn_Tracker.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"

using namespace devicebridge;

namespace
{
int freePort()
{
	const int s = socket(AF_INET, SOCK_STREAM, 0);
	sockaddr_in address{};
	address.sin_family = AF_INET;
	address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
	socklen_t length = sizeof address;
	if (bind(s, reinterpret_cast<sockaddr*>(&address), length) != 0 || getsockname(s, reinterpret_cast<sockaddr*>(&address), &length) != 0)
		return 0;
	close(s);
	return ntohs(address.sin_port);
}

struct Field
{
	vrpn_float32 origin[3] = {}, force[3] = {}, jacobian[3][3] = {}, radius = 0;
};

/// The server's side of a force device: it keeps the last field.
class Forces final : public vrpn_ForceDevice
{
public:
	Forces(const char* name, vrpn_Connection* c) : vrpn_ForceDevice(name, c)
	{
		register_autodeleted_handler(forcefield_message_id, &Forces::onField, this, d_sender_id);
	}
	void mainloop() override { server_mainloop(); }
	Field field;

private:
	static int VRPN_CALLBACK onField(void* self, vrpn_HANDLERPARAM p)
	{
		Field& f = static_cast<Forces*>(self)->field;
		return decode_forcefield(p.buffer, p.payload_len, f.origin, f.force, f.jacobian, &f.radius);
	}
};

class Server
{
public:
	std::mutex mutex;
	Field field;
	double position[3] = {0.01, -0.02, 0.03}, axis[3] = {0, 0, 0.5};  // the angular velocity about the axis is its length [rad/s]

	explicit Server(int port) : m_thread([this, port] { run(port); })
	{
		while (!m_listening) std::this_thread::sleep_for(std::chrono::milliseconds(1));
	}
	~Server()
	{
		m_running = false;
		m_thread.join();
	}

private:
	void run(int port)
	{
		vrpn_Connection* const connection = vrpn_create_server_connection(port);
		{
			vrpn_Tracker_Server tracker("Tool0", connection, 2);
			vrpn_Button_Server buttons("Tool0", connection, 3);
			Forces forces("Tool0", connection);
			buttons.set_button(1, 1);
			for (m_listening = true; m_running; std::this_thread::sleep_for(std::chrono::milliseconds(1)))
			{
				{
					const std::lock_guard<std::mutex> lock(mutex);
					report(tracker);
					field = forces.field;
				}
				tracker.mainloop();
				buttons.mainloop();
				forces.mainloop();
				connection->mainloop();
			}
		}
		connection->removeReference();
	}
	void report(vrpn_Tracker_Server& tracker)
	{
		timeval now{};
		vrpn_gettimeofday(&now, nullptr);
		const double speed = std::hypot(axis[0], axis[1], axis[2]), half = 0.25, half01 = 0.5 * speed * 0.01;
		double quat[4] = {0, std::sin(half), 0, std::cos(half)}, turn[4] = {0, 0, 0, std::cos(half01)};
		for (int i = 0; i < 3 && speed > 0; ++i) turn[i] = axis[i] / speed * std::sin(half01);
		const double velocity[3] = {0.1, 0.2, 0.3}, far[3] = {9, 9, 9};
		tracker.report_pose(0, now, far, quat);  // another sensor, which was not requested
		tracker.report_pose(1, now, position, quat);
		tracker.report_pose_velocity(1, now, velocity, turn, 0.01);
	}

	std::atomic<bool> m_running{true}, m_listening{false};
	std::thread m_thread;
};

class Vrpn : public testing::Test
{
protected:
	void SetUp() override
	{
		setenv("DEVICEBRIDGE_PLUGIN_PATH", PLUGIN_FOLDER, 1);
		m_port = freePort();
		ASSERT_GT(m_port, 0);
		m_server = std::make_unique<Server>(m_port);
		auto opened = DeviceRegistry().open("vrpn://127.0.0.1:" + std::to_string(m_port) + "/Tool0?sensor=1&peak_force=5&stiffness=300");
		ASSERT_TRUE(opened) << opened.error().message;
		m_device = std::move(opened).value();
	}

	int m_port = 0;
	std::unique_ptr<Server> m_server;
	std::unique_ptr<Device> m_device;
};
}  // namespace

TEST_F(Vrpn, PoseVelocityAndButtonsComeOverTheSocket)
{
	RealClock clock;
	DeviceState s;
	EXPECT_TRUE(within([&] {
		EXPECT_EQ(m_device->read(clock.now(), s), DeviceStatus::Ok);
		return s.sequence > 10 && s.buttons == 2 && !s.velocityEstimated;
	}));
	EXPECT_LT(distance(s.X_WH.translation, {0.01, -0.02, 0.03}), 1e-12);
	EXPECT_LT(distance(s.twist.linear, {0.1, 0.2, 0.3}), 1e-12);
	EXPECT_LT(distance(s.twist.angular, {0, 0, 0.5}), 1e-9);
	const ist::Vec3 turn = rotationVector(ist::quaternion(s.X_WH.rotation));
	EXPECT_LT(distance(turn, {0, 0.5, 0}), 1e-9);
	EXPECT_GE(m_device->info().nominalRate, 10);
	EXPECT_LE(m_device->info().nominalRate, 1000);
}

TEST_F(Vrpn, TheForceArrivesAsAFieldAboutTheHandAndEndsWithItsCommand)
{
	RealClock clock;
	DeviceCommand command;
	command.wrench.force = {0.5, -1, 2};
	// The force must arrive complete and at once, because a command that this thread renews late expires.
	Field field;
	const auto force = [&] {
		const std::lock_guard<std::mutex> lock(m_server->mutex);
		field = m_server->field;
		return ist::Vec3{field.force[0], field.force[1], field.force[2]};
	};
	EXPECT_TRUE(within([&] {
		command.computedAt = clock.now();
		command.expiresAt = command.computedAt + 100'000'000;
		EXPECT_EQ(m_device->write(command), DeviceStatus::Ok);
		return distance(force(), command.wrench.force) < 1e-6;
	}));
	EXPECT_LT(distance(ist::Vec3{field.origin[0], field.origin[1], field.origin[2]}, {0.01, -0.02, 0.03}), 1e-6);
	EXPECT_EQ(field.jacobian[1][1], 0);
	EXPECT_LE(field.radius, 0.1F);
	EXPECT_TRUE(within([&] { return norm(force()) == 0; }));
}

TEST_F(Vrpn, AServerThatDiesEndsTheForceAndIsExplained)
{
	DriverRun run(*m_device);
	run.expectLossIsSafe(*m_device, [&] { m_server.reset(); });
	EXPECT_NE(m_device->complaint().find("closed the connection"), std::string::npos) << m_device->complaint();
}
