// SPDX-License-Identifier: Zlib
#pragma once

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace browser
{
/// Window manager of an X server that has none: grants every size, and minimises a window that asks for it, as ICCCM wants it. Without one,
/// a request to be minimised has no effect.
class TinyWindowManager
{
public:
	TinyWindowManager() : m_display(XOpenDisplay(nullptr))
	{
		if (!m_display) return;
		m_state = XInternAtom(m_display, "WM_STATE", False);
		m_changeState = XInternAtom(m_display, "WM_CHANGE_STATE", False);
		refused() = false;
		// Other errors are of windows that were closed meanwhile.
		m_before = XSetErrorHandler([](Display*, XErrorEvent* error) {
			if (error->error_code == BadAccess) refused() = true;
			return 0;
		});
		XSelectInput(m_display, DefaultRootWindow(m_display), SubstructureRedirectMask | SubstructureNotifyMask);
		XSync(m_display, False);
		m_manages = !refused();
		m_thread = std::thread([this] { live(); });
	}
	~TinyWindowManager()
	{
		m_ending = true;
		if (m_thread.joinable()) m_thread.join();
		if (!m_display) return;
		XCloseDisplay(m_display);
		XSetErrorHandler(m_before);
	}
	/// False without a display, and on one that has a window manager.
	bool manages() const { return m_manages; }
	int minimised() const { return m_minimised; }

private:
	static std::atomic<bool>& refused()
	{
		static std::atomic<bool> is{false};
		return is;
	}
	void setState(Window window, long state) const
	{
		const long data[2] = {state, None};
		XChangeProperty(m_display, window, m_state, m_state, 32, PropModeReplace, reinterpret_cast<const unsigned char*>(data), 2);
	}
	void answer(XEvent& event)
	{
		if (event.type == MapRequest)
		{
			setState(event.xmaprequest.window, NormalState);
			XMapWindow(m_display, event.xmaprequest.window);
		}
		else if (event.type == ConfigureRequest)
		{
			const XConfigureRequestEvent& asked = event.xconfigurerequest;
			XWindowChanges changes{asked.x, asked.y, asked.width, asked.height, asked.border_width, asked.above, asked.detail};
			XConfigureWindow(m_display, asked.window, unsigned(asked.value_mask), &changes);
		}
		else if (event.type == ClientMessage && event.xclient.message_type == m_changeState && event.xclient.data.l[0] == IconicState)
		{
			setState(event.xclient.window, IconicState);
			XUnmapWindow(m_display, event.xclient.window);
			++m_minimised;
		}
	}
	void live()
	{
		while (!m_ending)
		{
			while (XPending(m_display))
			{
				XEvent event;
				XNextEvent(m_display, &event);
				answer(event);
			}
			XFlush(m_display);
			std::this_thread::sleep_for(std::chrono::milliseconds(1));
		}
	}

	Display* m_display;
	bool m_manages = false;
	XErrorHandler m_before = nullptr;
	Atom m_state = 0, m_changeState = 0;
	std::atomic<bool> m_ending{false};
	std::atomic<int> m_minimised{0};
	std::thread m_thread;
};
}  // namespace browser
