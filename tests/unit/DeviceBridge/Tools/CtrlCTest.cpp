// SPDX-License-Identifier: Zlib
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "tests/unit/OwnConsole.h"

using namespace devicebridge;

// On Linux Tools/devicebridge_command_test.sh does the same by a signal.
TEST(DevicebridgeCommand, CtrlCEndsARecordingThatIsWhole)
{
	if (!hasOwnConsole())
	{
		EXPECT_EQ(runTestInOwnConsole(), 0U);
		return;
	}
	constexpr unsigned long kInterrupted = 130, kBeforeItListened = 0xC000013A;  // the latter is STATUS_CONTROL_C_EXIT
	const std::string file =
		(std::filesystem::temp_directory_path() / ("ctrl-c" + std::to_string(::GetCurrentProcessId()) + ".istdrec")).string();
	unsigned long code = kBeforeItListened;
	for (int seconds = 1; seconds <= 16 && code == kBeforeItListened; seconds *= 2)
	{
		ignoreCtrlC(false);
		const StartedProgram record("\"" DEVICEBRIDGE_COMMAND "\" record sim:sigma7 --seconds 600 --real-time -o \"" + file + "\"");
		ignoreCtrlC(true);
		std::this_thread::sleep_for(std::chrono::seconds(seconds));
		EXPECT_TRUE(pressCtrlC());
		code = record.exitCode();
	}
	EXPECT_EQ(code, kInterrupted);
	{
		const auto recording = DeviceRegistry().open("replay:" + file);
		ASSERT_TRUE(recording) << recording.error().message;
		EXPECT_EQ(recording.value()->info().model, "sigma.7");
	}
	std::filesystem::remove(file);
}
