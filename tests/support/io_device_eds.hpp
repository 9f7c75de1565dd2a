#pragma once

#include <string_view>

namespace driveline::test {

/// EDS of an I/O device in the manner of CiA 401: 8 digital inputs and outputs, two analog ones of 16 bits, written by
/// hand.
inline constexpr std::string_view kIoDeviceEds = R"([FileInfo]
FileName=io.eds
EDSVersion=4.0
[DeviceInfo]
VendorName=Acme
VendorNumber=0x1234
ProductName=IO 8/8
ProductNumber=0x401
RevisionNumber=0x10002
BaudRate_125=1
BaudRate_500=1
BaudRate_1000=1
NrOfRXPDO=2
NrOfTXPDO=2
[MandatoryObjects]
SupportedObjects=3
1=0x1000
2=0x1001
3=0x1018
[OptionalObjects]
SupportedObjects=18
1=0x1003
2=0x1005
3=0x1008
4=0x1010
5=0x1014
6=0x1017
7=0x1400
8=0x1401
9=0x1600
10=0x1601
11=0x1800
12=0x1801
13=0x1A00
14=0x1A01
15=0x6000
16=0x6200
17=0x6401
18=0x6411
[ManufacturerObjects]
SupportedObjects=2
1=0x2000
2=0x2001
[1000]
ParameterName=Device type
DataType=7
AccessType=ro
DefaultValue=0x000F0191
[1001]
ParameterName=Error register
DataType=5
AccessType=ro
PDOMapping=1
[1003]
ParameterName=Error field
ObjectType=8
SubNumber=3
[1003sub0]
ParameterName=Number of errors
DataType=5
AccessType=rw
[1003sub1]
ParameterName=Newest
DataType=7
AccessType=ro
[1003sub2]
ParameterName=Older
DataType=7
AccessType=ro
[1005]
ParameterName=COB-ID SYNC
DataType=7
AccessType=rw
DefaultValue=0x80
[1008]
ParameterName=Name
DataType=9
AccessType=const
DefaultValue=IO 8/8
[1010]
ParameterName=Store
ObjectType=8
SubNumber=2
[1010sub0]
ParameterName=Largest
DataType=5
AccessType=ro
DefaultValue=1
[1010sub1]
ParameterName=Save all
DataType=7
AccessType=rw
DefaultValue=1
[1014]
ParameterName=COB-ID EMCY
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x80
[1017]
ParameterName=Heartbeat
DataType=6
AccessType=rw
DefaultValue=0
[1018]
ParameterName=Identity
ObjectType=9
SubNumber=5
[1018sub0]
ParameterName=Entries
DataType=5
AccessType=ro
DefaultValue=4
[1018sub1]
ParameterName=Vendor
DataType=7
AccessType=ro
DefaultValue=0x1234
[1018sub2]
ParameterName=Product
DataType=7
AccessType=ro
[1018sub3]
ParameterName=Revision
DataType=7
AccessType=ro
DefaultValue=0x10002
[1018sub4]
ParameterName=Serial
DataType=7
AccessType=ro
[1400]
ParameterName=RPDO 1
ObjectType=9
SubNumber=3
[1400sub0]
ParameterName=Largest
DataType=5
AccessType=ro
DefaultValue=2
[1400sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x200
[1400sub2]
ParameterName=Type
DataType=5
AccessType=rw
DefaultValue=255
[1401]
ParameterName=RPDO 2
ObjectType=9
SubNumber=3
[1401sub0]
ParameterName=Largest
DataType=5
AccessType=ro
DefaultValue=2
[1401sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
[1401sub2]
ParameterName=Type
DataType=5
AccessType=rw
DefaultValue=1
[1600]
ParameterName=Digital outputs
ObjectType=9
SubNumber=2
[1600sub0]
ParameterName=Entries
DataType=5
AccessType=rw
DefaultValue=1
[1600sub1]
ParameterName=Entry 1
DataType=7
AccessType=rw
DefaultValue=0x62000108
[1601]
ParameterName=Analog outputs
ObjectType=9
SubNumber=2
[1601sub0]
ParameterName=Entries
DataType=5
AccessType=rw
DefaultValue=1
[1601sub1]
ParameterName=Entry 1
DataType=7
AccessType=rw
DefaultValue=0x64110110
[1800]
ParameterName=TPDO 1
ObjectType=9
SubNumber=6
[1800sub0]
ParameterName=Largest
DataType=5
AccessType=ro
DefaultValue=5
[1800sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
DefaultValue=0x180 + $NodeID
[1800sub2]
ParameterName=Type
DataType=5
AccessType=rw
DefaultValue=255
[1800sub3]
ParameterName=Inhibit time
DataType=6
AccessType=rw
[1800sub5]
ParameterName=Event timer
DataType=6
AccessType=rw
[1801]
ParameterName=TPDO 2
ObjectType=9
SubNumber=3
[1801sub0]
ParameterName=Largest
DataType=5
AccessType=ro
DefaultValue=2
[1801sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x280
[1801sub2]
ParameterName=Type
DataType=5
AccessType=rw
DefaultValue=1
[1A00]
ParameterName=Digital inputs
ObjectType=9
SubNumber=2
[1A00sub0]
ParameterName=Entries
DataType=5
AccessType=rw
DefaultValue=1
[1A00sub1]
ParameterName=Entry 1
DataType=7
AccessType=rw
DefaultValue=0x60000108
[1A01]
ParameterName=Analog inputs
ObjectType=9
SubNumber=2
[1A01sub0]
ParameterName=Entries
DataType=5
AccessType=rw
DefaultValue=1
[1A01sub1]
ParameterName=Entry 1
DataType=7
AccessType=rw
DefaultValue=0x64010110
[2000]
ParameterName=Filter
DataType=6
AccessType=rw
DefaultValue=10
LowLimit=1
HighLimit=1000
[2001]
ParameterName=Label
DataType=9
AccessType=rw
DefaultValue=none
[6000]
ParameterName=Read inputs
ObjectType=8
SubNumber=2
[6000sub0]
ParameterName=Groups
DataType=5
AccessType=ro
DefaultValue=1
[6000sub1]
ParameterName=Inputs 1-8
DataType=5
AccessType=ro
PDOMapping=1
[6200]
ParameterName=Write outputs
ObjectType=8
SubNumber=2
[6200sub0]
ParameterName=Groups
DataType=5
AccessType=ro
DefaultValue=1
[6200sub1]
ParameterName=Outputs 1-8
DataType=5
AccessType=rww
PDOMapping=1
[6401]
ParameterName=Read analog
ObjectType=8
SubNumber=2
[6401sub0]
ParameterName=Channels
DataType=5
AccessType=ro
DefaultValue=1
[6401sub1]
ParameterName=Analog in
DataType=3
AccessType=ro
[6411]
ParameterName=Write analog
ObjectType=8
SubNumber=2
[6411sub0]
ParameterName=Channels
DataType=5
AccessType=ro
DefaultValue=1
[6411sub1]
ParameterName=Analog out
DataType=3
AccessType=rww
PDOMapping=1
)";

}  // namespace driveline::test
