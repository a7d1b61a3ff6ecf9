"""A Modbus TCP server of pymodbus on a port, with known registers. Usage: modbus_server.py PORT"""

import struct
import sys

from pymodbus.server import StartTcpServer

try:
    from pymodbus.datastore import ModbusDeviceContext as Device
    from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext
except ImportError:  # older releases
    from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext
    from pymodbus.datastore import ModbusSlaveContext as Device

inputs = [0] * 40
inputs[10] = 215  # 21.5 in tenths
inputs[11] = 0x10000 - 55  # -5.5 in tenths
inputs[12] = 0x8000  # no value
inputs[20], inputs[21] = struct.unpack(">HH", struct.pack(">f", 22.5))
inputs[23], inputs[22] = struct.unpack(">HH", struct.pack(">f", 23.5))
holding = [0] * 40
holding[30], holding[31] = 0, 24500  # thousandths

# The block counts from 1: the address 0 on the wire is its second argument's first value.
device = Device(ir=ModbusSequentialDataBlock(1, inputs), hr=ModbusSequentialDataBlock(1, holding))
try:
    context = ModbusServerContext(devices=device, single=True)
except TypeError:
    context = ModbusServerContext(slaves=device, single=True)
StartTcpServer(context=context, address=("127.0.0.1", int(sys.argv[1])))
