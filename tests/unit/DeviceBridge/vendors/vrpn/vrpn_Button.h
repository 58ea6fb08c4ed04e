// SPDX-License-Identifier: Zlib
#pragma once

// Names and signatures: vrpn_Button.h of github.com/vrpn/vrpn, 07.36.
#include "vrpn_Connection.h"

typedef struct _vrpn_BUTTONCB
{
	struct timeval msg_time;
	vrpn_int32 button;
	vrpn_int32 state;
} vrpn_BUTTONCB;
typedef void(VRPN_CALLBACK* vrpn_BUTTONCHANGEHANDLER)(void* userdata, const vrpn_BUTTONCB info);

const int vrpn_BUTTON_MAX_BUTTONS = 256;

typedef struct _vrpn_BUTTONSTATECB
{
	struct timeval msg_time;
	vrpn_int32 num_buttons;
	vrpn_int32 states[vrpn_BUTTON_MAX_BUTTONS];
} vrpn_BUTTONSTATESCB;
typedef void(VRPN_CALLBACK* vrpn_BUTTONSTATESHANDLER)(void* userdata, const vrpn_BUTTONSTATESCB info);

class VRPN_API vrpn_Button_Remote
{
public:
	vrpn_Button_Remote(const char* name, vrpn_Connection* cn = nullptr);
	virtual ~vrpn_Button_Remote(void);
	virtual void mainloop();
	virtual int register_change_handler(void* userdata, vrpn_BUTTONCHANGEHANDLER handler);
	virtual int unregister_change_handler(void* userdata, vrpn_BUTTONCHANGEHANDLER handler);
	virtual int register_states_handler(void* userdata, vrpn_BUTTONSTATESHANDLER handler);
	virtual int unregister_states_handler(void* userdata, vrpn_BUTTONSTATESHANDLER handler);

	bool shutup = false;

private:
	void* m_userdata = nullptr;
	vrpn_BUTTONSTATESHANDLER m_states = nullptr;
	vrpn_BUTTONCHANGEHANDLER m_handler = nullptr;
	unsigned m_told = 0;
};
