"""An OPC UA server of asyncua on a port, with known variables. Usage: opcua_server.py PORT

Lets in anybody, and the user ncfix with the password secret. Says "ready" when it listens.
"""

import asyncio
import logging
import sys
from datetime import datetime, timedelta, timezone

from asyncua import Server, ua
from asyncua.server.user_managers import User, UserManager, UserRole

logging.disable(logging.CRITICAL)


class Users(UserManager):
    def get_user(self, iserver, username=None, password=None, certificate=None):
        if isinstance(password, bytes):
            password = password.decode()
        if username is None or (username, password) == ("ncfix", "secret"):
            return User(role=UserRole.User, name=username)
        return None


async def main():
    server = Server(user_manager=Users())
    await server.init()
    # A name that nobody else knows, as servers behind a router have one.
    server.set_endpoint(f"opc.tcp://127.0.0.1:{sys.argv[1]}/cell/")
    await server.register_namespace("urn:machine")
    machine = await server.nodes.objects.add_object("ns=2;s=Machine", "2:Machine")

    async def add(node, value, kind, status=ua.StatusCodes.Good, ago_s=0):
        variable = await machine.add_variable(node, f"2:{node}", value, kind)
        read = datetime.now(timezone.utc) - timedelta(seconds=ago_s)
        await variable.write_value(
            ua.DataValue(ua.Variant(value, kind), ua.StatusCode(status), SourceTimestamp=read.replace(tzinfo=None))
        )
        return variable

    kinds = ua.VariantType
    await add("ns=2;s=Machine.T_head", 21.5, kinds.Double)
    await add("ns=2;i=17", -55, kinds.Int16)
    await add("ns=2;g=09087e75-8e5e-499b-954f-f2a9603db28a", 22.4, kinds.Float)
    await add("ns=2;b=TWFjaGluZQ==", 24500, kinds.UInt32)
    await add("ns=2;s=bad", 21.5, kinds.Double, ua.StatusCodes.BadNoCommunication)
    await add("ns=2;s=uncertain", 21.5, kinds.Double, ua.StatusCodes.UncertainLastUsableValue)
    await add("ns=2;s=set by hand", 21.5, kinds.Double, ua.StatusCodes.GoodLocalOverride)
    await add("ns=2;s=truth", True, kinds.Boolean)
    await add("ns=2;s=text", "21.5", kinds.String)
    await add("ns=2;s=array", [21.5, 22.5], kinds.Double)
    await add("ns=2;s=old", 23.5, kinds.Double, ago_s=3600)
    stamped = await add("ns=2;s=stamped", 25.5, kinds.Double)
    async with server:
        print("ready", flush=True)
        while True:
            await asyncio.sleep(0.2)
            # The same value, read anew.
            await stamped.write_value(25.5, kinds.Double)


asyncio.run(main())
