// SPDX-License-Identifier: Zlib
#pragma once

// Names and signatures: vrpn_ForceDevice.h of github.com/vrpn/vrpn, 07.36.
#include "vrpn_Connection.h"

class VRPN_API vrpn_ForceDevice_Remote
{
public:
	vrpn_ForceDevice_Remote(const char* name, vrpn_Connection* cn = nullptr);
	virtual ~vrpn_ForceDevice_Remote(void);
	virtual void mainloop();
	void setFF_Origin(vrpn_float32 x, vrpn_float32 y, vrpn_float32 z);
	void setFF_Force(vrpn_float32 fx, vrpn_float32 fy, vrpn_float32 fz);
	void setFF_Jacobian(vrpn_float32 dfxdx, vrpn_float32 dfxdy, vrpn_float32 dfxdz, vrpn_float32 dfydx, vrpn_float32 dfydy,
		vrpn_float32 dfydz, vrpn_float32 dfzdx, vrpn_float32 dfzdy, vrpn_float32 dfzdz);
	void setFF_Radius(vrpn_float32 r);
	void sendForceField(void);
	void stopForceField(void);

	bool shutup = false;

private:
	vrpn_float32 m_origin[3] = {}, m_force[3] = {}, m_radius = 0;
	bool m_hasJacobian = false;
};
