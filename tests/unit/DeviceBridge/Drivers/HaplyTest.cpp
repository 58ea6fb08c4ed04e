// SPDX-License-Identifier: Zlib
// The tests run against a service of their own on the loopback that speaks the documented protocol: the inventory first, then one state for
// each message. Keys are as in docs.haply.co (Inverse service 3.5) and in se3_haply.py of github.com/isaac-sim/IsaacLab.
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Haply/HaplyMessages.h"
#include "tests/unit/DeviceBridge/Drivers/DriverRun.h"

using namespace devicebridge;

namespace
{
using Json = nlohmann::json;
namespace asio = boost::asio;
using tcp = asio::ip::tcp;

class FakeService
{
public:
	enum class Mood
	{
		Good,
		Silent,   // receives messages, answers none
		Emptied,  // reports no device, as after unplugging
		Babbling  // sends text that is not JSON
	};
	std::atomic<Mood> mood{Mood::Good};
	std::atomic<bool> hasGrip{true};  // state of the first of two grips; the other has the opposite orientation
	std::atomic<int> messages{0}, refused{0};

	explicit FakeService(std::string kind = "inverse3")
		: m_kind(std::move(kind)),
		  m_acceptor(m_context, {asio::ip::address_v4::loopback(), 0}),
		  m_thread([this] { serve(); })
	{}
	~FakeService()
	{
		m_ending = true;
		hangUp();
		// A connection wakes the acceptor.
		boost::system::error_code ignored;
		asio::io_context context;
		tcp::socket(context).connect(m_acceptor.local_endpoint(), ignored);
		m_thread.join();
	}
	std::string uri(const std::string& options = "") const
	{
		return "haply://127.0.0.1:" + std::to_string(m_acceptor.local_endpoint().port()) + options;
	}
	void hangUp()
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		boost::system::error_code ignored;
		if (m_wire) m_wire->shutdown(tcp::socket::shutdown_both, ignored);
	}
	void place(const ist::Vec3& p, const ist::Vec3& v, const ist::Quaternion& q, unsigned buttons)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_position = p, m_velocity = v, m_orientation = q, m_buttons = buttons;
	}
	ist::Vec3 force()
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		return m_force;
	}

private:
	static Json vectorOf(const ist::Vec3& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }
	std::string state()
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		Json message = {{m_kind, Json::array()}, {"session", {{"id", 1}}}};
		if (mood == Mood::Emptied) return message.dump();
		for (const char* id : {"0432", "0577"})
		{
			const ist::Vec3 p = id[1] == '4' ? m_position : -m_position;
			const Json state = {{"cursor_position", vectorOf(p)}, {"cursor_velocity", vectorOf(m_velocity)}};
			message[m_kind].push_back({{"device_id", id}, {"state", state}});
		}
		message["wireless_verse_grip"] = Json::array();
		const Json buttons = {{"a", (m_buttons & 1) != 0}, {"b", (m_buttons & 2) != 0}, {"c", (m_buttons & 4) != 0}};
		for (const char* id : {"61576", "61580"})
		{
			const bool first = id[3] == '7';
			if (first && !hasGrip) continue;
			Json orientation = vectorOf((first ? 1 : -1) * ist::Vec3{m_orientation.x, m_orientation.y, m_orientation.z});
			orientation["w"] = m_orientation.w;
			message["wireless_verse_grip"].push_back({{"device_id", id}, {"state", {{"orientation", orientation}, {"buttons", buttons}}}});
		}
		return message.dump();
	}
	void take(const std::string& text)
	{
		const Json message = Json::parse(text, nullptr, false);
		++messages;
		const std::lock_guard<std::mutex> lock(m_mutex);
		try
		{
			const Json& device = message.at(m_kind).at(0);
			const Json& v = device.at("commands").at("set_cursor_force").at("vector");
			if (device.at("device_id") == "0432") m_force = {v.at("x"), v.at("y"), v.at("z")};
		}
		catch (const std::exception&)
		{
			++refused;
		}
	}
	void serve()
	{
		while (!m_ending)
		{
			tcp::socket socket(m_context);
			boost::system::error_code failure;
			m_acceptor.accept(socket, failure);
			if (failure || m_ending) return;
			setWire(&socket);
			talk(socket);
			setWire(nullptr);
			const std::lock_guard<std::mutex> lock(m_mutex);
			m_force = {};  // the service drops the force of a client that has gone
		}
	}
	void setWire(tcp::socket* wire)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_wire = wire;
	}
	void talk(tcp::socket& socket)
	{
		boost::system::error_code failure;
		socket.set_option(tcp::no_delay(true), failure);
		boost::beast::websocket::stream<tcp::socket&> stream(socket);
		stream.accept(failure);
		stream.text(true);
		if (!failure) stream.write(asio::buffer(state()), failure);
		while (!failure)
		{
			boost::beast::flat_buffer buffer;
			stream.read(buffer, failure);
			if (failure) return;
			take(boost::beast::buffers_to_string(buffer.data()));
			if (mood == Mood::Silent) continue;
			// Slow, so that the driver also waits in vain for a time before the device counts as lost.
			if (mood == Mood::Emptied) std::this_thread::sleep_for(std::chrono::milliseconds(20));
			const std::string answer = mood == Mood::Babbling ? "{]" : state();
			stream.write(asio::buffer(answer), failure);
		}
	}

	std::string m_kind;  ///< kind of its devices
	asio::io_context m_context;
	tcp::acceptor m_acceptor;
	std::mutex m_mutex;
	tcp::socket* m_wire = nullptr;
	ist::Vec3 m_position{0.01, 0.02, 0.03}, m_velocity, m_force;
	ist::Quaternion m_orientation;
	unsigned m_buttons = 0;
	std::atomic<bool> m_ending{false};
	std::thread m_thread;
};

std::unique_ptr<Device> opened(const std::string& uri)
{
	auto device = DeviceRegistry().open(uri);
	if (device) return std::move(device).value();
	ADD_FAILURE() << device.error().message;
	return nullptr;
}
}  // namespace

TEST(Haply, StatesOfTheServiceArrive)
{
	FakeService service;
	const auto device = opened(service.uri());
	ASSERT_TRUE(device);
	EXPECT_EQ(device->info().serial, "0432");
	EXPECT_TRUE(device->info().sensed & kRotation);
	EXPECT_EQ(device->info().actuated, static_cast<unsigned>(kTranslation));
	std::mt19937_64 random(5);
	std::normal_distribution<double> normal;
	RealClock clock;
	for (unsigned round = 0; round < 20; ++round)
	{
		const ist::Vec3 p{0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)},
			v{normal(random), normal(random), normal(random)};
		const ist::Quaternion q = ist::quaternionFromRotationVector(ist::Vec3{normal(random), normal(random), normal(random)});
		service.place(p, v, q, round % 8);
		DeviceState s;
		EXPECT_TRUE(within([&] {
			EXPECT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
			const ist::Vec3 turn = rotationVector(ist::quaternion(s.X_WH.rotation * transpose(rotationMatrix(q))));
			return s.X_WH.translation == p && s.twist.linear == v && norm(turn) < 1e-9 && s.buttons == round % 8;
		}));
	}
	EXPECT_EQ(service.refused, 0);
}

// An Inverse3 is felt by the recipe of docs/stability.md without further settings. For the other models no source gives the stiffness.
TEST(Haply, LimitsAreThoseOfItsModelAndSaySo)
{
	for (const std::string kind : {"inverse3", "inverse3x", "minverse"})
	{
		FakeService service(kind);
		const auto device = opened(service.uri());
		ASSERT_TRUE(device);
		const DeviceInfo& info = device->info();
		EXPECT_EQ(info.model, kind);
		EXPECT_EQ(info.peakForce, 10);
		EXPECT_EQ(info.continuousForce, 4);
		EXPECT_TRUE(info.assumed & kAssumedPeakForce);
		EXPECT_NE(info.source.find("assumed"), std::string::npos) << info.source;
		{
			DriverRun run(*device);
			EXPECT_GT(run.forceByRecipe(*device, 0), 0);
			EXPECT_TRUE(run.until([&] { return norm(service.force()) > 0; }));
		}
		if (kind != "inverse3")
		{
			EXPECT_EQ(info.maxStiffness, 0);
			EXPECT_TRUE(info.profile.empty());
			EXPECT_NE(info.source.find("unknown: max_stiffness"), std::string::npos) << info.source;
			continue;
		}
		EXPECT_EQ(info.maxStiffness, 1000);
		EXPECT_EQ(info.maxDamping, 5);
		EXPECT_EQ(info.profile, "inverse3");
		for (const double damping : {info.damping, 2.5})
		{
			DriverRun run(*device);
			EXPECT_GT(run.forceByRecipe(*device, damping), 0);
			EXPECT_TRUE(run.until([&] { return norm(service.force()) > 0; }));
		}
	}
}

TEST(Haply, AngularVelocityIsThatOfTheTurningGrip)
{
	FakeService service;
	const auto device = opened(service.uri());
	ASSERT_TRUE(device);
	RealClock clock;
	const ist::Vec3 omega{0.5, -1, 0.25};
	const std::int64_t start = clock.now();
	std::vector<double> estimates[3];
	DeviceState s;
	while (clock.now() < start + 500'000'000)
	{
		service.place({}, {}, ist::quaternionFromRotationVector((1e-9 * static_cast<double>(clock.now() - start)) * omega), 0);
		ASSERT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
		if (clock.now() > start + 50'000'000)
			for (int k = 0; k < 3; ++k) estimates[k].push_back(s.twist.angular[k]);
		clock.sleepUntil(clock.now() + 200'000);
	}
	ASSERT_GT(estimates[0].size(), 20U);
	ist::Vec3 median;  // median of each component: the machine may pause between two poses, which makes one estimate too slow and the next
					   // too fast
	for (int k = 0; k < 3; ++k)
	{
		const auto middle = estimates[k].begin() + static_cast<std::ptrdiff_t>(estimates[k].size() / 2);
		std::nth_element(estimates[k].begin(), middle, estimates[k].end());
		median[k] = *middle;
	}
	EXPECT_LT(distance(median, omega), 0.3 * norm(omega));
}

TEST(Haply, ASilentGripStaysAsItWas)
{
	FakeService service;
	RealClock clock;
	const ist::Quaternion q = ist::quaternionFromRotationVector(ist::Vec3{0.4, -0.8, 0.3}),
						  later = ist::quaternionFromRotationVector(ist::Vec3{-1, 0.2, 2});
	service.place({}, {}, q, 5);
	const auto device = opened(service.uri());
	ASSERT_TRUE(device);
	DeviceState s;
	const auto turned = [&](const ist::Quaternion& from) {
		return norm(rotationVector(ist::quaternion(s.X_WH.rotation * transpose(rotationMatrix(from)))));
	};
	const auto reach = [&](double x) {
		return within([&] { return device->read(clock.now(), s) == DeviceStatus::Ok && s.X_WH.translation.x == x; });
	};
	service.place({1, 0, 0}, {}, q, 5);
	ASSERT_TRUE(reach(1));
	EXPECT_EQ(s.buttons, 5U);
	service.hasGrip = false;
	service.place({2, 0, 0}, {}, later, 5);
	ASSERT_TRUE(reach(2));
	EXPECT_LT(turned(q), 1e-9);
	EXPECT_EQ(s.buttons, 0U);
	const std::int64_t end = clock.now() + 20'000'000;
	for (; clock.now() < end; clock.sleepUntil(clock.now() + 500'000))
	{
		ASSERT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
		ASSERT_TRUE(turned(q) < 1e-9 && s.twist.angular == ist::Vec3());
	}
	// Once awake, the grip has its new orientation, without an angular velocity from the jump.
	service.hasGrip = true;
	service.place({3, 0, 0}, {}, later, 1);
	ASSERT_TRUE(reach(3));
	EXPECT_LT(turned(later), 1e-9);
	const std::int64_t still = clock.now() + 20'000'000;
	for (; clock.now() < still; clock.sleepUntil(clock.now() + 500'000))
	{
		ASSERT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
		ASSERT_LT(norm(s.twist.angular), 1e-6);
	}
}

TEST(Haply, TheGripThatWasNamedTurnsTheHandle)
{
	FakeService service;
	RealClock clock;
	const ist::Quaternion q = ist::quaternionFromRotationVector(ist::Vec3{0.4, -0.8, 0.3});
	service.place({1, 0, 0}, {}, q, 0);
	const std::pair<const char*, ist::Mat3> grips[] = {{"", rotationMatrix(q)}, {"?grip=61576", rotationMatrix(q)},
		{"?grip=61580", transpose(rotationMatrix(q))}, {"?grip=1", ist::Pose().rotation}};
	for (const auto& [option, R] : grips)
	{
		const auto device = opened(service.uri(option));
		ASSERT_TRUE(device);
		DeviceState s;
		ASSERT_EQ(device->read(clock.now(), s), DeviceStatus::Ok);
		EXPECT_LT(norm(rotationVector(ist::quaternion(s.X_WH.rotation * transpose(R)))), 1e-9) << option;
		EXPECT_EQ((device->info().sensed & kRotation) != 0, std::string(option) != "?grip=1") << option;
	}
}

TEST(Haply, ForcesReachTheDeviceThatWasNamed)
{
	FakeService service;
	RealClock clock;
	DeviceCommand command;
	command.wrench.force = {0.5, -1.25, 2};
	const auto push = [&](Device& device) {
		command.computedAt = clock.now();
		command.expiresAt = command.computedAt + 100'000'000;
		EXPECT_EQ(device.write(command), DeviceStatus::Ok);
	};
	{
		const auto device = opened(service.uri("?device=0432"));
		ASSERT_TRUE(device);
		EXPECT_TRUE(within([&] { return push(*device), service.force() == command.wrench.force; }));
		EXPECT_TRUE(within([&] { return service.force() == ist::Vec3{}; }));  // the command expires by itself
		EXPECT_TRUE(within([&] { return push(*device), service.force() == command.wrench.force; }));
	}
	EXPECT_TRUE(within([&] { return service.force() == ist::Vec3{}; }));
	const auto other = opened(service.uri("?device=0577"));
	ASSERT_TRUE(other);
	DeviceState s;
	ASSERT_EQ(other->read(clock.now(), s), DeviceStatus::Ok);
	EXPECT_EQ(s.X_WH.translation.x, -0.01);
	other->close();
	const auto missing = DeviceRegistry().open(service.uri("?device=1"));
	ASSERT_FALSE(missing);
	EXPECT_NE(missing.error().message.find("has no device 1"), std::string::npos) << missing.error().message;
}

TEST(Haply, EveryLossEndsTheForceAndIsExplained)
{
	using Mood = FakeService::Mood;
	const std::pair<std::function<void(FakeService&)>, const char*> losses[] = {
		{[](FakeService& s) { s.hangUp(); }, "closed the connection"}, {[](FakeService& s) { s.mood = Mood::Silent; }, "does not answer"},
		{[](FakeService& s) { s.mood = Mood::Emptied; }, "has left"}, {[](FakeService& s) { s.mood = Mood::Babbling; }, "no JSON"}};
	for (const auto& [pull, word] : losses)
	{
		FakeService service;
		const auto device = opened(service.uri());
		ASSERT_TRUE(device);
		DriverRun run(*device);
		run.expectLossIsSafe(*device, [&, &pull = pull] { pull(service); });
		EXPECT_NE(device->complaint().find(word), std::string::npos) << device->complaint();
	}
}

TEST(Haply, ComesBackAfterTheServiceWasRestarted)
{
	FakeService service;
	const auto device = opened(service.uri("?reconnect=on"));
	ASSERT_TRUE(device);
	RealClock clock;
	DeviceState s;
	service.hangUp();
	EXPECT_TRUE(within([&] { return device->read(clock.now(), s) == DeviceStatus::Disconnected; }));
	EXPECT_TRUE(within([&] { return device->read(clock.now(), s) == DeviceStatus::Ok; }));
}

TEST(Haply, RefusesWhatIsNoneInASentence)
{
	const DeviceRegistry registry;
	// A port that was free a moment ago.
	std::string free;
	{
		FakeService service;
		free = service.uri();
	}
	const std::pair<std::string, const char*> wrong[] = {{free, "no Haply Inverse service"}, {"haply://host:port", "haply://HOST:PORT"},
		{"haply:?api=2", "api=2"}, {"haply:?colour=red", "colour"}};
	for (const auto& [uri, word] : wrong)
	{
		const auto device = registry.open(uri);
		ASSERT_FALSE(device) << uri;
		EXPECT_NE(device.error().message.find(word), std::string::npos) << device.error().message;
	}
}

TEST(Haply, NoMessageBreaksTheReader)
{
	const std::string whole = R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":1,"y":2,"z":3}}}],)"
							  R"("wireless_verse_grip":[{"state":{"orientation":{"w":1,"x":0,"y":0,"z":0},"buttons":{"a":true}}}]})";
	const auto read = readHaplyMessage(whole, "");
	ASSERT_TRUE(read && read.value());
	EXPECT_EQ(read.value()->position.y, 2);
	std::mt19937 random(11);
	int kept = 0;
	for (int i = 0; i < 20000; ++i)
	{
		std::string text = whole;
		for (int n = static_cast<int>(random() % 4); n >= 0; --n)
		{
			const std::size_t at = random() % text.size();
			if (random() % 3 == 0) text.erase(at, 1 + random() % 8);
			else text[at] = "{}[]\",:0123456789aexnul"[random() % 23];
			if (text.empty()) text = "x";
		}
		const auto broken = readHaplyMessage(text, "");
		EXPECT_EQ(static_cast<bool>(broken), Json::parse(text, nullptr, false).is_object());
		kept += broken && broken.value() && isFinite(broken.value()->position);
	}
	EXPECT_GT(kept, 100);
	const Json force = Json::parse(haplyForceMessage("inverse3", "a\"b", {1, 2, 3}, true));
	EXPECT_EQ(force["inverse3"][0]["device_id"], "a\"b");
	EXPECT_EQ(force["inverse3"][0]["commands"]["set_cursor_force"]["values"]["z"], 3);
}
