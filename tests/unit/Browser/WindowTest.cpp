// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Window.h"
#include "demos/browser/render/Picture.h"

#include "tests/unit/Browser/RecordedHand.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <unistd.h>
#include <vector>

#ifdef HAS_X11
#include "tests/unit/Browser/TinyWindowManager.h"  // last: it brings the macros of Xlib
#endif

using namespace browser;

namespace
{
WindowOptions hello()
{
	WindowOptions options;
	options.demo.cache = TREE_FOLDER;
	options.demo.spheres = 300;
	options.width = 400;
	options.height = 300;
	return options;
}

/// A window needs a display: window_test.sh gives one.
#define OPEN_OR_SKIP(options) \
	if (const auto failed = openWindow(options)) \
	{ \
		if (failed->message.find("no window can be opened") != std::string::npos) GTEST_SKIP() << failed->message; \
		FAIL() << failed->message; \
	}
}  // namespace

TEST(Window, BearsEverySizeAndBeingMinimised)
{
	WindowOptions options = hello();
	options.besideStock = true;
	options.sizes = {{400, 300}, {800, 600}, {1, 1}, {0, 0}, {0, 0}, {399, 17}, {17, 399}, {640, 361}, {640, 361}, {640, 361}};
	options.pictures = static_cast<long long>(options.sizes.size()) + 2;
	options.screenshot = (std::filesystem::temp_directory_path() / ("window-test-" + std::to_string(::getpid()) + ".png")).string();
	OPEN_OR_SKIP(options);
	const auto picture = loadPicture(options.screenshot);
	std::filesystem::remove(options.screenshot);
	ASSERT_TRUE(picture) << picture.error().message;
	EXPECT_EQ(picture.value().width, 640);
	EXPECT_EQ(picture.value().height, 361);
}

TEST(Window, OpensAgainAfterItWasClosed)
{
	WindowOptions options = hello();
	options.pictures = 2;
	OPEN_OR_SKIP(options);
	OPEN_OR_SKIP(options);
}

TEST(Window, NamesADeviceThatIsNotThere)
{
	WindowOptions options = hello();
	options.pictures = 2;
	options.device = "nosuchdriver:0";
	const auto failed = openWindow(options);
	ASSERT_TRUE(failed);
	if (failed->message.find("no window can be opened") != std::string::npos) GTEST_SKIP() << failed->message;
	EXPECT_NE(failed->message.find("nosuchdriver"), std::string::npos) << failed->message;
}

// After four pictures; what is then said is Browser.ALostDeviceIsSaidAndTheDemoGoesOn.
TEST(Window, StaysWhenItsDeviceIsLost)
{
	const RecordedHand recorded({0.05, 0, 0}, 4);
	WindowOptions options = hello();
	options.pictures = 12;
	options.device = recorded.address();
	int drawn = 0;
	options.afterPicture = [&] { ++drawn; };
	OPEN_OR_SKIP(options);
	EXPECT_EQ(drawn, 12);
}

#ifdef HAS_X11
// The demo goes on, nothing is drawn, and the window comes back as it was.
TEST(Window, RestsWhileItIsMinimised)
{
	TinyWindowManager manager;
	if (!manager.manages()) GTEST_SKIP() << "runs on a display without a window manager: ctest -R browser_window";
	WindowOptions options = hello();
	options.sizes.assign(24, {0, 0});
	for (int i = 0; i < 12; ++i) options.sizes.push_back({500, 400});
	options.pictures = static_cast<long long>(options.sizes.size());
	std::vector<bool> minimised;
	std::vector<int> drawn;
	options.beforePicture = [&](bool is) { minimised.push_back(is), drawn.push_back(0); };
	options.afterPicture = [&] { ++drawn.back(); };
	options.screenshot = (std::filesystem::temp_directory_path() / ("minimised-test-" + std::to_string(::getpid()) + ".png")).string();
	OPEN_OR_SKIP(options);
	EXPECT_GE(manager.minimised(), 1);
	ASSERT_EQ(minimised.size(), options.sizes.size());
	EXPECT_TRUE(minimised[23]);
	EXPECT_FALSE(minimised.back());
	for (size_t i = 0; i < drawn.size(); ++i) EXPECT_EQ(drawn[i], minimised[i] ? 0 : 1) << i;
	const auto picture = loadPicture(options.screenshot);
	std::filesystem::remove(options.screenshot);
	ASSERT_TRUE(picture) << picture.error().message;
	EXPECT_EQ(picture.value().width, 500);
}
#endif
