// SPDX-License-Identifier: Zlib
#pragma once

// Names and signatures: vrpn_Tracker.h and vrpn_BaseClass.h of github.com/vrpn/vrpn, 07.36.
#include "vrpn_Connection.h"

const int vrpn_ALL_SENSORS = -1;

typedef struct _vrpn_TRACKERCB
{
	struct timeval msg_time;
	vrpn_int32 sensor;
	vrpn_float64 pos[3];
	vrpn_float64 quat[4];
} vrpn_TRACKERCB;
typedef void(VRPN_CALLBACK* vrpn_TRACKERCHANGEHANDLER)(void* userdata, const vrpn_TRACKERCB info);

typedef struct _vrpn_TRACKERVELCB
{
	struct timeval msg_time;
	vrpn_int32 sensor;
	vrpn_float64 vel[3];
	vrpn_float64 vel_quat[4];
	vrpn_float64 vel_quat_dt;
} vrpn_TRACKERVELCB;
typedef void(VRPN_CALLBACK* vrpn_TRACKERVELCHANGEHANDLER)(void* userdata, const vrpn_TRACKERVELCB info);

class VRPN_API vrpn_Tracker_Remote
{
public:
	vrpn_Tracker_Remote(const char* name, vrpn_Connection* c = nullptr);
	virtual ~vrpn_Tracker_Remote(void);
	virtual void mainloop();
	virtual int register_change_handler(void* userdata, vrpn_TRACKERCHANGEHANDLER handler, vrpn_int32 sensor = vrpn_ALL_SENSORS);
	virtual int unregister_change_handler(void* userdata, vrpn_TRACKERCHANGEHANDLER handler, vrpn_int32 sensor = vrpn_ALL_SENSORS);
	virtual int register_change_handler(void* userdata, vrpn_TRACKERVELCHANGEHANDLER handler, vrpn_int32 sensor = vrpn_ALL_SENSORS);
	virtual int unregister_change_handler(void* userdata, vrpn_TRACKERVELCHANGEHANDLER handler, vrpn_int32 sensor = vrpn_ALL_SENSORS);

	bool shutup = false;

private:
	bool m_known = false;
	void* m_userdata = nullptr;
	vrpn_TRACKERCHANGEHANDLER m_pose = nullptr;
	vrpn_TRACKERVELCHANGEHANDLER m_velocity = nullptr;
};
