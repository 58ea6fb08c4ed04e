// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Tools/Commands.h"

#include "BulletISTCollision/Core/Base/Version.h"
#include "BulletISTCollision/Core/Platform/CommandProcess.h"
#include "BulletISTCollision/Core/Platform/Environment.h"
#include "BulletISTCollision/Tools/IntegerArgument.h"
#include "BulletISTCollision/Tools/UnknownCommand.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

namespace devicebridge::tools
{
namespace
{
constexpr const char* kVersion = "devicebridge " BULLETHAPTICS_VERSION;

class CommandLine
{
public:
	CommandLine()
	{
		m_app.require_subcommand(1);
		m_app.set_version_flag("--version", kVersion);
		add("list", "Drivers and the devices that they offer", [this] { return runList(m_run.json); });
		addRun("info", "What a device is and can bear", runInfo, false);
		addState();
		addRun("monitor", "Print the samples of a device as CSV; sends no force", runMonitor, true)
			->add_option("--rate", m_run.rate, "lines in a second [Hz]")
			->check(CLI::Range(0.1, 1000.0))
			->capture_default_str();
		CLI::App* record = addRun("record", "Feel an elastic wall below z = 0 and write down what passes", runRecord, true);
		record->add_option("-o,--output", m_run.output, "recording to write")->required();
		record->add_option("--hand", m_run.hand, "CSV to write the joints of a tracked hand to; motion:FILE plays it");
		CLI::App* replay = add("replay", "Repeat a recorded run and compare each command bit for bit", [this] { return runReplay(m_run); });
		replay->add_option("file", m_run.uri, "recording")->required();
		for (const char* name : {"record", "replay", "selftest"})
		{
			if (std::string(name) == "selftest") addRun(name, "Check the safety chain on a device", runSelfTest, true);
			m_app.get_subcommand(name)
				->add_option("--stiffness", m_run.stiffness, "of the wall [N/m] (half of what the device bears)")
				->check(CLI::NonNegativeNumber);
		}
		CLI::App* calibrate = add(
			"calibrate", "Fit a data glove to the hand that wears it, from two poses", [this] { return runCalibrate(m_run); });
		calibrate->add_option("address", m_run.uri, "address of the glove, for instance glove:/dev/ttyUSB0")->required();
		calibrate->add_option("-o,--output", m_run.output, "calibration to write")->required();
		CLI::App* acceptance = addRun("acceptance", "Walk a person through a device, and write a file to send", runAcceptance, false);
		acceptance->add_option("-o,--output", m_run.output, "file to write (JSON)")->required();
		acceptance->add_flag("--without-forces", m_run.withoutForces, "leave out the parts that need forces");
		acceptance->add_flag("--real-time", m_run.realTime, "run a simulated device by the clock on the wall, too");
		addZWidth();
	}

	int run(const std::vector<std::string>& arguments)
	{
		if (arguments.size() > 1)
			if (const std::string sentence = ist::tools::unknownCommand(arguments[1], commands()); !sentence.empty())
				return fail(sentence, kUsage);
		try
		{
			m_app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend() - 1));  // the last one first
		}
		catch (const CLI::ParseError& e)
		{
			return m_app.exit(e) == 0 ? kGood : kUsage;
		}
		const int code = m_command();
		const bool printed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
		return printed || code != kGood ? code : fail("standard output cannot be written");
	}

private:
	std::vector<std::string> commands() const
	{
		std::vector<std::string> names;
		for (const CLI::App* sub : m_app.get_subcommands([](const CLI::App*) { return true; })) names.push_back(sub->get_name());
		return names;
	}

	CLI::App* add(const char* name, const char* description, std::function<int()> command)
	{
		CLI::App* sub = m_app.add_subcommand(name, description);
		sub->set_version_flag("--version", kVersion);
		if (std::string(name) != "monitor") sub->add_flag("--json", m_run.json, "one JSON object");
		sub->callback([this, command] { m_command = command; });
		return sub;
	}

	CLI::App* addRun(const char* name, const char* description, int (*command)(const RunArguments&), bool timed)
	{
		CLI::App* sub = add(name, description, [this, command] { return command(m_run); });
		sub->add_option("address", m_run.uri, "address of the device, for instance sim:touchx")->required();
		if (!timed) return sub;
		sub->add_flag("--real-time", m_run.realTime, "run by the clock on the wall (virtual time)");
		sub->add_option("--seconds", m_run.seconds, "how long")->check(CLI::Range(0.001, 3600.0))->capture_default_str();
		return sub;
	}

	void addState()
	{
		CLI::App* sub = add("state", "What devices do now: ready, lost, buttons, rate; sends no force", [this] {
			m_state.json = m_run.json;
			return runState(m_state);
		});
		sub->add_option("address", m_state.uris, "addresses of devices, for instance sim:touchx")->required();
		sub->add_flag("--watch", m_state.watch, "print each change, such as an unplugged device, instead of a table");
		sub->add_option("--seconds", m_state.seconds, "how long (0.5; with --watch an hour)")->check(CLI::Range(0.1, 86400.0));
	}

	void addZWidth()
	{
		CLI::App* sub = add("zwidth", "Largest stable stiffness of a virtual wall over its damping", [this] {
			m_zwidth.json = m_run.json;
			return runZWidth(m_zwidth);
		});
		sub->add_option("address", m_zwidth.uri, "simulated device")->capture_default_str();
		sub->add_option("--delay-ticks", m_zwidth.delayTicks, "by which a command takes effect later")
			->transform(ist::tools::integerArgument(0, 31));
		sub->add_flag("--quantised", m_zwidth.quantised, "positions come in the steps of the device's resolution");
		sub->add_option("--steps", m_zwidth.steps, "dampings")->transform(ist::tools::integerArgument(1, 1000))->capture_default_str();
		sub->add_option("--max-damping", m_zwidth.most, "largest damping of the wall [N s/m]")->check(CLI::NonNegativeNumber);
	}

	CLI::App m_app{"Haptic devices: list, inspect, record, replay, measure", "devicebridge"};
	std::function<int()> m_command;
	RunArguments m_run;
	StateArguments m_state;
	ZWidthArguments m_zwidth;
};
}  // namespace
}  // namespace devicebridge::tools

int main(int argc, char** argv)
{
	ist::prepareCommand();
	// The messages of OpenXR's loader are replaced by the sentence that `list` prints.
	ist::setEnvironmentDefault("XR_LOADER_DEBUG", "none");
	try
	{
		return devicebridge::tools::CommandLine().run(ist::commandArguments(argc, argv));
	}
	catch (const std::exception& e)
	{
		return devicebridge::tools::fail(std::string("internal error: ") + e.what(), devicebridge::tools::kInternal);
	}
}
