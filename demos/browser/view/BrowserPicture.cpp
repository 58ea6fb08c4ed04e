// SPDX-License-Identifier: Zlib
#include "demos/browser/render/OffscreenContext.h"
#include "demos/browser/view/Browser.h"

namespace browser
{
ist::Result<Picture> takeBrowserPicture(const std::string& demo, double seconds, const DemoOptions& options, int width, int height)
{
	auto context = OffscreenContext::make();
	if (!context) return context.error();
	auto renderer = Renderer::make();
	if (!renderer) return renderer.error();
	PictureTarget target(width, height);
	Gui gui(height / 720.0);
	Browser browser(*renderer.value(), gui, options);
	browser.open(demo);
	if (!browser.demo()) return ist::Error{browser.message()};
	browser.beautiful();
	while (browser.demo()->time() < seconds) browser.key(Key::Step);
	browser.key(Key::Pause);
	// ImGui lays its windows out in the first pictures; after that they stay.
	for (int i = 0; i < 3; ++i)
	{
		gui.beginOffscreen(width, height);
		browser.draw(target.frame(), width, height);
		gui.end(target.frame(), width, height);
	}
	return target.read();
}
}  // namespace browser
